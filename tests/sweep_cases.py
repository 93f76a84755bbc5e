"""A case that is computed in no time, and sweeps of it."""

CASE = """
title = "Weight on a spring"

[time]
end = "1 s"
window = "50 ms"

[body.weight]
kind = "particle"
position = [0.5, 0.0, 0.0]
mass = "2 kg"

[joint.line]
kind = "guide"
a = { body = "weight" }
directions = [[0, 1, 0], [0, 0, 1]]

[joint.spring]
kind = "spring"
a = { body = "weight" }
b = { body = "ground", position = [0.0, 0.0, 0.0] }
stiffness = "8 N/m"
length = "0.4 m"

[probe.weight]
body = "weight"

[variant.heavy]
set = { "body.weight.mass" = "4 kg" }

[sweep.stiffness]
title = "Weight on springs"
vary."joint.spring.stiffness" = ["8 N/m", "18 N/m", "32 N/m"]

[sweep.stiffness.quantity.place]
of = "probe.weight.x"
printed = [0.35, nan, 0.5]

[sweep.stiffness.portrait.motion]
x = "probe.weight.x"
y = "probe.weight.vx"

[sweep.two]
set = { "time.end" = "0.5 s" }
design = { kind = "full-factorial" }

[sweep.two.factor.mass]
entries = ["body.weight.mass"]
low = "1 kg"
high = "4000 g"
scale = "logarithmic"

[sweep.two.factor.stiffness]
entries = ["joint.spring.stiffness"]
low = "4 N/m"
high = "16 N/m"

[sweep.two.quantity.place]
of = "probe.weight.x"
"""
