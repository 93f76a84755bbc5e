"""Tube in tube: line contact of a cylinder in a bore, preloaded pads, statics of both."""

import numpy as np
import pytest

from mechanics import kernels
from mechanics.contact import cylinder_indentation, effective_modulus
from mechanics.description import (
    AxialDrive,
    Beam,
    Clamp,
    Description,
    Fixing,
    Force,
    Friction,
    NormalContact,
    Preload,
    Site,
    Telescope,
)
from mechanics.dynamics import Control
from mechanics.layout import Layout
from mechanics.march import COLUMNS, DEFECT, DEPTH, ELASTIC, GAP, NUMERICAL
from mechanics.march.program import WORK_DRIVE
from mechanics.solver import Mechanics
from mechanics.statics import Equilibrium, equilibrium
from mechanics.telescope import build
from meshes.materials import constant_material
from meshes.sections import tube as ring

AMBIENT = 298.15
STEEL = constant_material("steel", 8000.0, 193e9, 0.29, 17e-6, 16.2, 500.0)
ALUMINIUM = constant_material("aluminium", 2700.0, 69e9, 0.33, 23.1e-6, 167.0, 896.0)
RADIUS, CLEAR = 0.05, 1e-3
PADS = Preload(200.0, 1e5)
X, Y, Z = np.eye(3)


def tube(name, start, end, nodes, radius, material=ALUMINIUM, **options):
    points = np.column_stack([np.linspace(start, end, nodes), np.zeros((nodes, 2))])
    axes = np.tile(np.eye(3), (nodes, 1, 1))
    section = ring(radius, 2e-3)
    return Beam(name, points, axes, section, material, AMBIENT, damping_time=1e-3, **options)


def tubes(length=2.0, inner=3):
    """An arm from .5 on in a boom of 1.2 m."""
    arm = tube("arm", 0.5, 0.5 + length, inner, RADIUS - 1e-3)
    return [arm, tube("boom", 0.0, 1.2, 4, RADIUS + 2e-3, STEEL)]


def sleeve(**options):
    return Telescope("sleeve", "arm", "boom", RADIUS, CLEAR, AMBIENT, **options)


class Scene:
    def __init__(self, **options):
        bodies, joint = tubes(), sleeve(**options)
        self.layout = Layout.of(bodies, [joint])
        (self.term,) = build([joint], self.layout)
        self.q = self.layout.q0.copy()
        self.set()

    def set(self, arm=AMBIENT, boom=AMBIENT):
        T = np.zeros((len(self.layout.x), 3))
        T[self.layout.point_index["arm"], 0] = arm
        T[self.layout.point_index["boom"], 0] = boom
        self.coef = self.term.coefficients(T)
        return self

    def push(self, way):
        self.q[self.layout.node_dofs["arm"][:, None] + np.arange(3)] += way
        return self

    def respond(self):
        v = np.zeros_like(self.q)
        rows = kernels.responses(self.term, self.q, v, self.coef, COLUMNS)
        return dict(zip([s.label for s in self.term.stations], rows, strict=True))

    def energy(self, q):
        return kernels.energies(self.term, q, np.zeros_like(q), self.coef)[0]

    def force(self):
        out = np.zeros_like(self.q)
        kernels.add_force(self.term, self.q, np.zeros_like(self.q), self.coef, out)
        return out


def slopes(function, x, step=1e-7):
    shifts = step * np.eye(x.size)
    return np.array([(function(x + e) - function(x - e)) / (2.0 * step) for e in shifts])


# -- line contact --------------------------------------------------------------------------------


@pytest.mark.parametrize("stations", [0, 3])
def test_cylinder_by_johnson_with_tributary_lengths(stations):
    """δ = F/(π E* L) (ln(4 π E* L ΔR/F) - 1), L the part of the tube that belongs to a station."""
    scene = Scene(contact=NormalContact("cylinder"), stations=stations)
    depth = 2e-5
    found = scene.push((CLEAR + depth) * Y).respond()
    E = effective_modulus(69e9, 0.33, 193e9, 0.29)
    spacing = 1.0 / (stations + 1)
    lengths = {"node_00": 0.5 * spacing, "mouth": 0.5 * spacing}
    lengths |= {f"station_00_{k}": spacing for k in range(1, stations + 1) if 0.5 + k * spacing < 1}
    for label, length in lengths.items():
        force, K = found[label][ELASTIC], np.pi * E * length
        assert force > 0.0
        assert cylinder_indentation(force, K, 4.0 * K * CLEAR) == pytest.approx(
            found[label][DEPTH], rel=1e-9
        )
        assert found[label][DEPTH] == pytest.approx(depth, rel=1e-4)
    assert sum(s.length for s in scene.term.stations[:-1]) == pytest.approx(2.0)


def test_force_of_a_line_contact_does_not_depend_on_how_finely_it_is_divided():
    """Of a tube that is inside as a whole, pressed evenly: π E* L by its length, mouth aside."""
    sums = []
    for stations in (0, 1, 4):
        scene = Scene(contact=NormalContact("cylinder"), stations=stations)
        scene.push(np.array([-0.45, CLEAR + 1e-6, 0.0]))
        rows = scene.respond()
        share = {s.label: s.length for s in scene.term.stations}
        pressed = [k for k in rows if rows[k][ELASTIC] > 0.0 and k != "mouth"]
        sums.append(sum(rows[k][ELASTIC] for k in pressed) / sum(share[k] for k in pressed))
    assert sums == pytest.approx([sums[0]] * 3, rel=1e-6)


def test_the_slope_of_the_energy_of_a_cylinder_is_its_force():
    scene = Scene(contact=NormalContact("cylinder"), stations=1)
    scene.set(arm=AMBIENT + 30.0).push(np.array([0.0, CLEAR, -5e-4]))
    slope = slopes(scene.energy, scene.q)
    assert np.abs(slope).max() > 1e3
    assert scene.force() == pytest.approx(slope, abs=1e-5 * np.abs(slope).max())


# -- pads ----------------------------------------------------------------------------------------


def test_rings_of_pads_are_at_the_mouth_and_at_the_heel():
    names = Scene(preload=PADS, contact=NormalContact("linear", 1e8)).term.contact_names
    assert names[-3:] == ["sleeve.mouth", "sleeve.mouth_pads", "sleeve.heel_pads"]
    heel = Scene(preload=PADS).term.stations[-1]
    assert heel.node == 0 and heel.sign == 1.0


@pytest.mark.parametrize("way", [0.0, 1e-5, 3e-4, 9e-4])
def test_a_ring_of_pads_is_a_spring_sideways(way):
    """K D towards the middle, N² = N0² + (K D)²; walls do not touch."""
    scene = Scene(preload=PADS).push(way * Y)
    rows = scene.respond()
    for label in ("mouth_pads", "heel_pads"):
        normal = np.hypot(PADS.force, PADS.stiffness * way)
        assert rows[label][ELASTIC] == pytest.approx(normal, rel=1e-9)
    total = scene.force()[scene.layout.node_dofs["arm"] + 1].sum()
    assert total == pytest.approx(2.0 * PADS.stiffness * way, abs=1e-9)
    assert rows["node_00"][ELASTIC] == 0.0


@pytest.mark.parametrize("warmer", [-30.0, 0.0, 40.0])
def test_pads_follow_thermal_strain(warmer):
    """N0 + 2 K (c0 - c), and nothing once the pads are off."""
    scene = Scene(preload=PADS).set(arm=AMBIENT + warmer, boom=AMBIENT)
    closing = 23.1e-6 * warmer * RADIUS
    at_rest = PADS.force + 2.0 * PADS.stiffness * closing
    assert scene.respond()["heel_pads"][ELASTIC] == pytest.approx(at_rest, rel=1e-9)
    cold = scene.set(arm=AMBIENT - 1200.0)
    off = 23.1e-6 * 1200.0 * RADIUS - 0.5 * PADS.force / PADS.stiffness
    assert off > 0.0 and cold.respond()["heel_pads"][GAP] == pytest.approx(off)
    assert cold.respond()["heel_pads"][ELASTIC] == 0.0


def test_the_slope_of_the_energy_of_pads_is_their_force():
    scene = Scene(preload=PADS, friction=None).push(np.array([0.0, 4e-4, -2e-4]))
    scene.q += 1e-4 * np.random.default_rng(0).standard_normal(scene.q.size)
    slope = slopes(scene.energy, scene.q)
    assert np.abs(slope).max() > 30.0
    assert scene.force() == pytest.approx(slope, abs=1e-6 * np.abs(slope).max())


def test_pads_need_positive_numbers():
    with pytest.raises(ValueError, match="preload are positive"):
        Scene(preload=Preload(0.0, 1e5))


def test_a_preloaded_arm_sticks_until_all_pads_slip():
    """Pulled slowly with a growing force: μ (N0 + N0) holds it, and no more."""
    friction = Friction(0.3, law="stick", presliding=1e-5)
    pull = 0.3 * 2.0 * PADS.force
    joints = [Clamp("base", Site("boom", 0), Site(None)), sleeve(preload=PADS, friction=friction)]
    load = Force("pull", Site("arm", 0), X, lambda t: pull * t)
    mechanics = Mechanics(
        Description(tubes(), joints, [load]), Control(tolerance=1e-6, largest_step=2e-3)
    )
    T = np.tile([AMBIENT, 0.0, 0.0], (len(mechanics.x), 1))
    ways, state = [], mechanics.initial(T)
    for _ in range(11):
        state, _, why = mechanics.advance(state, 0.1, T, T)
        assert not why, why
        ways.append(state.motion.q[0] - 0.5)
    assert ways[8] < 1e-5 and ways[9] < 2e-5  # 90 %, 100 % of what holds
    assert ways[10] > 1e-4


# -- statics, drive ------------------------------------------------------------------------------


@pytest.mark.parametrize("overlap", [0.7, 0.5])
def test_tip_load_on_an_arm_in_a_mouth(overlap):
    """Mouth F L/a, inner end F (L - a)/a; the tip is at -c - (2 c/a)(L - a) and what bends more."""
    length, load = 2.0, 0.1
    arm = tube("arm", 1.2 - overlap, 1.2 - overlap + length, 9, RADIUS - 1e-3)
    boom = tube("boom", 0.0, 1.2, 5, RADIUS + 2e-3, STEEL)
    hold = AxialDrive("screw", Site("arm", 0), Site("boom", 0), X)
    plane = [Fixing(f"plane_{i}", "arm", i, "position", Z) for i in (0, 8)]
    plane.append(Fixing("turn", "arm", 0, "r_y", Z))
    joints = [Clamp("base", Site("boom", 0), Site(None)), hold, *plane,
              sleeve(contact=NormalContact("linear", 1e8))]  # fmt: skip
    push = Force("push", Site("arm", 8), -Y, lambda t: load)
    system = Mechanics(Description([arm, boom], joints, [push]), Control()).system
    coef = system.coefficients(np.tile([AMBIENT, 0.0, 0.0], (len(system.layout.x), 1)))
    q = system.layout.q0
    lean = 2.0 * CLEAR / overlap
    start, near = q.copy(), 1.0 + 8e-6
    nodes = system.layout.node_dofs["arm"]
    start[nodes + 1] = near * (CLEAR - lean * (q[nodes] - q[nodes[0]]))
    start[nodes + 4] = -near * lean
    begin = Equilibrium(start, np.zeros(system.m), 0, 0.0, "")
    found = equilibrium(system, coef, coef, start=begin, time=1.0)
    assert not found.why, found.why
    y = system.unknowns(found.q, found.lam)
    rows = system.respond(y, np.zeros_like(y), coef)[:, ELASTIC]
    force = dict(zip(system.contact_names, rows, strict=True))
    assert force["sleeve.mouth"] == pytest.approx(load * length / overlap, rel=2e-3)
    assert force["sleeve.node_00"] == pytest.approx(load * (length - overlap) / overlap, rel=2e-3)
    drop = CLEAR + lean * (length - overlap)
    assert -found.q[nodes[-1] + 1] == pytest.approx(drop, rel=1e-3)


def test_the_work_of_the_drive_is_in_the_ledger():
    """Preloaded pads slip under a screw: its work is friction, kinetic and stored energy."""
    friction = Friction(0.3, law="stick", presliding=1e-5)
    joints = [
        Clamp("base", Site("boom", 0), Site(None)),
        sleeve(preload=PADS, friction=friction),
        AxialDrive("screw", Site("arm", 0), Site("boom", 0), X, lambda t: 0.1 * t * t),
    ]
    mechanics = Mechanics(Description(tubes(), joints), Control(tolerance=1e-6, largest_step=1e-3))
    T = np.tile([AMBIENT, 0.0, 0.0], (len(mechanics.x), 1))
    state, heat, why = mechanics.advance(mechanics.initial(T), 0.3, T, T)
    assert not why, why
    way, mu_n = 0.1 * 0.09, 0.3 * 2.0 * PADS.force
    assert heat.sum() == pytest.approx(mu_n * way, rel=5e-3)
    assert state.ledger[WORK_DRIVE] == pytest.approx(mu_n * way, rel=1e-2)
    assert abs(state.ledger[DEFECT]) < 1e-6 * state.ledger[WORK_DRIVE]
    assert abs(state.ledger[NUMERICAL]) < 1e-2 * state.ledger[WORK_DRIVE]
    assert state.motion.q[0] == pytest.approx(0.5 + way, abs=1e-9)
