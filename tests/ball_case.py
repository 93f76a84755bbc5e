"""The smallest case: a ball that falls, and two variants of it."""

BALL = """
[time]
end = "1 s"
window = "0.25 s"

[body.ball]
kind = "particle"
position = [0, 0, 0]
mass = "2 kg"

[gravity]
acceleration = [0, 0, -2.0]

[probe.ball]
body = "ball"

[variant.heavy]
title = "a heavier ball, for longer"
set = { "body.ball.mass" = "5 kg", "time.end" = "2 s" }

[variant.weightless]
without = ["gravity"]
"""
