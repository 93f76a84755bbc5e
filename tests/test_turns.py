"""Turns of sections, angles of joints, journals in bores: against closed forms."""

from pathlib import Path

import numpy as np
import pytest

from coupling.casefile import from_text
from coupling.errors import BadCase
from coupling.report_tables import Sought
from coupling.reports.timed_runs import DONE, timed


def courses(text: str, *wanted: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times, and courses by what they are of."""
    ran = timed(from_text(text, Path(".")), {of: Sought(of=of) for of in wanted}, repeat=0)
    assert ran.outcome == DONE, ran.reason
    return ran.times, {of: rows[:, 0] for of, rows in ran.values.items()}


DRIVEN = """
[time]
end = "2 s"
window = "50 ms"
[body.base]
kind = "rigid"
mass = 1
inertia = [0.1, 0.1, 0.1]
position = [0, 0, 0]
[body.arm]
kind = "rigid"
mass = 1
inertia = [0.1, 0.2, 0.3]
position = [0.4, 0, 0]
[joint.first]
kind = "revolute"
a = { body = "base", position = [0, 0, 0] }
b = { body = "ground" }
axis = [0, 0, 1]
angle = { table = [["0 s", "0 deg"], ["3 s", "900 deg"]] }
[joint.second]
kind = "revolute"
a = { body = "arm", position = [0, 0, 0] }
b = { body = "base", position = [0, 0, 0] }
axis = [1, 2, 2]
angle = { table = [["0 s", "0 deg"], ["3 s", "-2160 deg"]] }
[probe.base]
body = "base"
[probe.root]
body = "arm"
"""


def test_driven_revolutes_turn_as_they_are_driven():
    """Also one on a body that turns, more than once round, about an oblique axis."""
    t, found = courses(
        DRIVEN, "joint.first.angle", "joint.first.rate", "joint.second.angle", "joint.second.rate",
        "probe.base.rz", "probe.base.rx", "probe.base.wz", "probe.root.wx", "probe.root.wz",
    )  # fmt: skip
    first, second = np.radians(300.0), np.radians(-720.0)
    assert found["joint.first.angle"] == pytest.approx(first * t, abs=1e-8)
    assert found["joint.second.angle"] == pytest.approx(second * t, abs=1e-8)
    assert found["probe.base.rz"] == pytest.approx(first * t, abs=1e-8)
    assert found["probe.base.rx"] == pytest.approx(0.0 * t, abs=1e-9)
    late = t > 0.5  # the drive begins with a jump of the speed
    assert found["joint.first.rate"][late] == pytest.approx(first, rel=2e-3)
    assert found["joint.second.rate"][late] == pytest.approx(second, rel=2e-3)
    # the angular velocity of the arm: that of the base and its own about an axis turned with it
    own = found["joint.second.rate"] / 3.0
    c, s = np.cos(found["joint.first.angle"]), np.sin(found["joint.first.angle"])
    assert found["probe.root.wx"] == pytest.approx(own * (c - 2.0 * s), abs=2e-3)
    assert found["probe.root.wz"] == pytest.approx(2.0 * own + found["joint.first.rate"], abs=2e-3)


TOP = """
[time]
end = "2 s"
window = "5 ms"
[integrator]
largest_step = "1 ms"
[body.top]
kind = "rigid"
mass = 1
inertia = [0.2, 0.2, 0.1]
position = [0, 0, 0]
spin = [0.6, 0.0, 4.0]
[probe.top]
body = "top"
"""


def test_a_free_top_precesses():
    """Torque-free, I1 = I2: w(t) = L/I1 + w3 (1 - I3/I1) e3(t), e3 about L at |L|/I1 (Euler)."""
    t, found = courses(TOP, *(f"probe.top.{key}{axis}" for key in "wr" for axis in "xyz"))
    L = np.array([0.2 * 0.6, 0.0, 0.1 * 4.0])
    rate, along = np.linalg.norm(L) / 0.2, L / np.linalg.norm(L)
    e3 = np.array([0.0, 0.0, 1.0])
    e3_along, e3_across = (e3 @ along) * along, e3 - (e3 @ along) * along
    side = np.cross(along, e3)
    c, s = np.cos(rate * t)[:, None], np.sin(rate * t)[:, None]
    w = L / 0.2 + 4.0 * 0.5 * (e3_along + c * e3_across + s * side)
    turned = t[:, None] * (L / 0.2 + 4.0 * 0.5 * e3_along)
    turned = turned + 4.0 * 0.5 / rate * (s * e3_across + (1.0 - c) * side)
    for k, axis in enumerate("xyz"):
        assert found[f"probe.top.w{axis}"] == pytest.approx(w[:, k], abs=2e-4)
        assert found[f"probe.top.r{axis}"] == pytest.approx(turned[:, k], abs=5e-4)


BORE = """
[time]
end = "1 s"
window = "5 ms"
[body.pin]
kind = "rigid"
mass = "0.1 kg"
inertia = [0.001, 0.001, 0.001]
position = ["1 mm", 0, 0]
velocity = [0, 6.91150384e-3, 0]
[joint.bore]
kind = "clearance_revolute"
journal = { body = "pin", position = ["1 mm", 0, 0] }
bearing = { body = "ground", position = [0, 0, 0] }
axis = [0, 0, 1]
radius = "10 mm"
clearance = "1 mm"
journal_material = "al6061"
bearing_material = "al6061"
[joint.bore.contact]
stiffness = "linear"
value = "1e6 N/m"
restitution = 0.5
[load.x]
kind = "force"
at = { body = "pin" }
direction = [1, 0, 0]
amplitude = { sine = { amplitude = "100 N", frequency = "1 Hz", phase = "90 deg", offset = 0 } }
[load.y]
kind = "force"
at = { body = "pin" }
direction = [0, 1, 0]
amplitude = { sine = { amplitude = "100 N", frequency = "1 Hz", offset = 0 } }
"""


def test_a_journal_is_led_round_the_bore_by_a_turning_force():
    """Radius c + F/k = 1.1 mm, at the rate of the force; m r Omega^2 is 4e-5 of the force."""
    keys = "x", "y", "vx", "vy", "force", "radius_gap"
    t, found = courses(BORE, *(f"contact.bore.{key}" for key in keys))
    x, y, vx, vy, force, gap = (found[f"contact.bore.{key}"] for key in keys)
    assert gap == pytest.approx(1e-3, rel=1e-12)
    late = t > 0.5  # the force is there at once
    assert np.hypot(x, y)[late] == pytest.approx(1.1e-3, rel=2e-3)
    assert force[late] == pytest.approx(100.0, rel=2e-2)
    assert np.hypot(vx, vy)[late] == pytest.approx(2.0 * np.pi * 1.1e-3, rel=0.1)
    turned = np.unwrap(np.arctan2(y, x))
    turned -= turned[0]
    assert np.abs(turned) == pytest.approx(2.0 * np.pi * t, abs=2e-2)
    spun = (x * vy - y * vx) / (x * x + y * y)
    assert np.trapezoid(spun, t) == pytest.approx(turned[-1], rel=2e-3)


def test_what_has_no_turn_is_refused():
    text = DRIVEN + '[report.r]\nvary."time.end" = ["1 s"]\n'
    bad = {
        "probe.root.rw": "there is no quantity of a probe 'rw'",
        "joint.third.angle": "there is no joint that turns",
        "joint.first.torque": "there is no quantity of a joint",
        "contact.first.x": "there is no joint with clearance",
    }
    for k, of in enumerate(bad):
        text += f'[report.r.quantity.q{k}]\nof = "{of}"\nexact = 1.0\n'
    with pytest.raises(BadCase) as error:
        from_text(text, Path("."))
    said = [problem.text for problem in error.value.problems]
    assert len(said) == len(bad)
    for expected, text in zip(bad.values(), said, strict=True):
        assert expected in text
