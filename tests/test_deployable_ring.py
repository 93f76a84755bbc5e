"""The ring that deploys: its closed form, mobility counted, and its motion against both."""

from pathlib import Path

import numpy as np
import pytest

from coupling import casefile, simulation
from coupling.deployment import deployable, winch_law
from coupling.deployment_tables import DeployableRing, Winch
from coupling.errors import BadCase
from coupling.model import build
from coupling.reading import Results
from mechanics import march
from meshes.deployable_ring import Form, corners, deployable_ring, held_corners, slope_of

FORM = Form(6, 10.0, 2.0)

CASE = """
[time]
end = "40 s"
window = "4 s"
[integrator]
tolerance = 1e-4
newton_tolerance = 1e-10
[section.tube]
kind = "tube"
mean_radius = "50 mm"
thickness = "2 mm"
[generate.ring]
kind = "deployable_ring"
bays = 6
diameter = "10 m"
height = "2 m"
fraction = 0.3
section = "tube"
outer_section = "tube"
inner_section = "tube"
material = "al6061"
damping = "1 ms"
[generate.ring.rope]
stiffness = "1 MN"
damping = "100 kN s"
[generate.ring.resistance]
moment = "5 N m"
damping = "100 N m s/rad"
[generate.ring.winch]
duration = "38 s"
overrun = "2 mm"
"""
PLAY = """
[generate.ring.clearance]
radius = "10 mm"
clearance = "30 um"
[generate.ring.clearance.sliders]
length = "0.2 m"
height = "50 mm"
corner_radius = "5 mm"
"""
GREASED = PLAY.replace('"30 um"', '"30 um"\ngrease = "5 kN s/m"')
PRESSED = GREASED + 'press = "20 N m"\npivots = "1 kN m s/rad"\n'


def read(tmp_path: Path, text: str):
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    return casefile.read(tmp_path)


@pytest.mark.parametrize("fraction", [0.1, 0.5, 1.0])
def test_panels_are_parallelograms_that_keep_their_members(fraction):
    low, up = corners(FORM, slope_of(fraction))
    for rim in (low, up):
        sides = np.roll(rim, -1, axis=0) - rim
        assert np.allclose(np.linalg.norm(sides, axis=1), FORM.chord, rtol=1e-14)
    assert np.allclose(up - low, [0.0, 0.0, 2.0])
    assert np.allclose(np.hypot(*low[:, :2].T), 5.0 * fraction)


@pytest.mark.parametrize("fraction", [0.1, 0.5, 1.0])
def test_rope_is_as_long_as_the_way_through_the_corners(fraction):
    ring, slope = deployable_ring(FORM, fraction), slope_of(fraction)
    ends = corners(FORM, slope)
    number = {bar.name: i for i, bar in enumerate(b for b in ring.bars if b.kind == "batten")}
    way = np.array([ends[int(c.at == "end"), number[c.post]] for c in ring.rope])
    length = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
    assert FORM.rope(slope) == pytest.approx(length, rel=1e-14)
    assert np.array_equal(way[0], way[-1])


def test_tubes_lie_in_one_another_at_every_fraction():
    for fraction in (0.05, 0.5, 1.0):
        ring = deployable_ring(FORM, fraction)
        bars = {bar.name: bar for bar in ring.bars}
        for panel in ring.panels:
            outer, inner = bars[panel.outer], bars[panel.inner]
            inside = (inner.start - outer.start) @ panel.axis
            assert 0.0 < inside < FORM.tube
            assert np.allclose(np.cross(inner.end - outer.start, panel.axis), 0.0, atol=1e-12)


def test_rigid_panels_have_as_many_motions_as_said():
    """Posts only shift: panels of slope s_k close where sum cos s_k t_k = 0, sum sin s_k = 0."""
    n, slope = FORM.bays, slope_of(0.5)
    angle = 2.0 * np.pi * (np.arange(n) + 0.5) / n
    sign = (-1.0) ** np.arange(n)
    closing = np.stack(
        [np.sin(slope) * np.sin(angle) * sign, np.sin(slope) * np.cos(angle) * sign,
         np.cos(slope) * np.ones(n)]
    )  # fmt: skip
    assert n - np.linalg.matrix_rank(closing) == n - 3
    wheels = np.array([np.eye(n)[k] + np.eye(n)[(k + 1) % n] for k in range(n)])
    assert n - np.linalg.matrix_rank(np.concatenate([closing, wheels])) == 1


@pytest.mark.parametrize("text", [CASE, CASE + PLAY], ids=["ideal", "play"])
def test_every_joint_is_satisfied_and_none_repeats_another(tmp_path, text):
    system = build(read(tmp_path, text)).motion_solver.system
    coef = system.coefficients(np.full((len(system.layout.x), 3), 300.0))
    y = system.unknowns(system.layout.q0)
    assert np.abs(system.constraints(y, 0.0, coef)).max() < 1e-12
    rows = system.jacobian(y, 0.0, coef).toarray()[:, : system.n] * system.scale[: system.n]
    size = np.linalg.norm(rows, axis=1, keepdims=True)
    rows = rows[size[:, 0] > 0.0] / size[size > 0.0][:, None]  # latches hold nothing yet
    assert np.linalg.svd(rows, compute_uv=False)[-1] > 1e-6


def test_winch_follows_one_acceleration_and_winds_the_overrun():
    winch = Winch(start=2.0, duration=10.0, overrun=0.01, points=101)
    times, angle = winch_law(FORM, slope_of(0.2), winch)
    assert times[0] == 2.0 and times[-1] == 12.0
    assert angle[0] == slope_of(0.2)
    assert FORM.rope(float(angle[-1])) == pytest.approx(FORM.rope(0.0) - 0.01)
    rates = np.diff(angle, 2) / 0.01
    assert np.allclose(rates[:45], rates[0], rtol=1e-6)
    assert np.allclose(rates[55:], -rates[0], rtol=1e-6)


def test_lever_is_the_slope_of_the_length_of_the_diagonal():
    slope, h = 0.7, 1e-5
    found = (FORM.diagonal(slope + h) - FORM.diagonal(slope - h)) / (2.0 * h)
    assert FORM.lever(slope) == pytest.approx(found, rel=1e-9)


def test_swing_is_what_the_diagonal_turns():
    slope, h = 0.7, 1e-5
    low, high = (deployable_ring(FORM, np.cos(x)).panels[0].axis for x in (slope - h, slope + h))
    turned = np.linalg.norm(high - low) / (2.0 * h)
    assert FORM.swing(slope) == pytest.approx(turned, rel=1e-3)


def test_deploys_along_its_closed_form_and_latches(tmp_path):
    """Against the posts of a rigid ring whose rope has the length that the winch asks for."""
    scene = read(tmp_path, CASE)
    done = simulation.run(scene, tmp_path / "out")
    assert done.code == 0
    start, ring = slope_of(0.3), scene.generate["ring"]
    times, slopes = winch_law(FORM, start, ring.winch)
    with Results.open(done.folder) as results:
        time = results["frames/time"]
        posts = [f"bodies/batten_{k}/position" for k in range(6)]
        found = np.stack([results[name] for name in posts], axis=1).swapaxes(1, 2)
    for t, there in zip(time[::20], found[::20], strict=True):
        slope = max(float(np.interp(t, times, slopes)), 0.0)  # the latch
        assert np.abs(there - held_corners(FORM, slope, start)).max() < 5e-3
    assert np.abs(found[-1] - held_corners(FORM, 0.0, start)).max() < 2e-3
    assert np.linalg.norm(found[-1, 0, 0] - found[-1, 0, 3]) == pytest.approx(10.0, abs=2e-3)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("bays = 6", "bays = 7"), "must be even"),
        (("fraction = 0.3", "fraction = 1.5"), "at most 1"),
        (("[generate.ring.rope]", "[generate.ring.shock]"), "from"),
    ],
)
def test_bad_tables_are_named(tmp_path, change, said):
    with pytest.raises(BadCase, match=said):
        read(tmp_path, CASE.replace(*change))


def test_names_are_those_of_the_table():
    table = DeployableRing(
        kind="deployable_ring", bays=6, diameter=10.0, height=2.0, fraction=0.3, section="s",
        outer_section="s", inner_section="s", material="al6061",
    )  # fmt: skip
    made = deployable(table)
    assert len(made["body"]) == 5 * 6
    kinds = [joint["kind"] for joint in made["joint"].values()]
    assert [kinds.count(k) for k in ("revolute", "prismatic", "gear", "latch")] == [24, 6, 6, 6]


def seated(tmp_path: Path) -> tuple[list[str], np.ndarray]:
    """Names of the contacts of a folded ring at rest, and with what force [N] each is pressed."""
    text = CASE.replace("40 s", "1 s").replace("4 s", "0.25 s").replace("38 s", "1 h")
    model = build(read(tmp_path, text.replace("5 N m", "50 N m") + PRESSED))
    last = []
    attempts = simulation.Attempts(lambda: None, lambda rows: last.append(rows), lambda: None)
    for window in simulation.windows(model, model.initial(), attempts=attempts):
        assert isinstance(window, simulation.Done)
    return model.motion_solver.system.contact_names, last[-1].response[-1, :, march.ELASTIC]


def test_what_presses_pins_and_sliders_seats_them(tmp_path):
    """Two bars on two supports with a moment at one end, joined by a couple of the slider."""
    names, force = seated(tmp_path)
    slope = slope_of(0.3)
    whole = FORM.diagonal(slope)
    at = whole - FORM.tube
    couple = 20.0 * (1.0 - at / whole)
    pressed = {name: f for name, f in zip(names, force, strict=True) if "slider" in name}
    assert all(f > 0.0 for name, f in zip(names, force, strict=True) if name not in pressed)
    for k in range(6):
        own = [f for name, f in pressed.items() if name.startswith(f"slider_{k}.")]
        assert sum(f > 0.0 for f in own) == 2
        assert 0.5 * 0.2 * sum(own) == pytest.approx(couple, rel=0.1)
