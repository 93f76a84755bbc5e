"""Tube in tube: virtual work, power, tangents, places of contact, closed forms, temperature."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import fsolve, minimize_scalar
from scipy.spatial.transform import Rotation

from mechanics import kernels
from mechanics.contact_laws import (
    ACTIVE,
    APPROACH,
    CLEARANCE,
    HISTORIES,
    HISTORY,
    KINETIC,
    SLOT,
    STEP,
)
from mechanics.description import (
    Beam,
    Clamp,
    Description,
    Friction,
    NormalContact,
    Site,
    Telescope,
)
from mechanics.dynamics import Control
from mechanics.layout import Layout
from mechanics.march import (
    COLUMNS,
    CONTACT_ELASTIC,
    DEFECT,
    DEPTH,
    DEPTH_RATE,
    DISSIPATIVE,
    ELASTIC,
    FRICTION,
    GAP,
    NUMERICAL,
    PATH,
    PATH_RATE,
    PLACE,
    RUBBED,
    SLIP,
    STUCK,
)
from mechanics.solver import Mechanics
from mechanics.telescope import ROUNDING, build
from meshes.materials import constant_material
from meshes.sections import tube as ring

AMBIENT = 298.15
STEEL = constant_material("steel", 8000.0, 193e9, 0.29, 17e-6, 16.2, 500.0)
ALUMINIUM = constant_material("aluminium", 2700.0, 69e9, 0.33, 23.1e-6, 167.0, 896.0)
RADIUS, CLEAR, STIFFNESS = 0.05, 0.01, 2e4
LAWS = {
    "none": None,
    "regularised": Friction(0.3, regularisation_speed=0.05),
    "stick": Friction(0.3, law="stick", static_coefficient=0.4, presliding=1e-2),
    "slide": Friction(0.3, law="stick", static_coefficient=0.4, presliding=1e-5),
    "lugre": Friction(0.3, law="lugre", static_coefficient=0.4, presliding=1e-3, viscous=0.2),
}


def tube(name, start, end, nodes, material=ALUMINIUM, y=0.0, element="beam3243"):
    points = np.column_stack([np.linspace(start, end, nodes), np.full(nodes, y), np.zeros(nodes)])
    axes = np.tile(np.eye(3), (nodes, 1, 1))
    return Beam(name, points, axes, None, material, AMBIENT, element=element)


class Scene:
    """Inner tube from x = .55 to 2, outer one from 0 to 1.2 unless told, at rest."""

    def __init__(self, inner=(0.55, 2.0, 5), outer=(0.0, 1.2, 4), **options):
        law = {"value": STIFFNESS, "restitution": 0.8} | options.pop("law", {})
        bodies = [tube("arm", *inner), tube("boom", *outer, material=STEEL)]
        data = {"stations": 1, "friction": LAWS["regularised"]} | options
        joint = Telescope(
            "sleeve", "arm", "boom", RADIUS, CLEAR, AMBIENT, contact=NormalContact(**law), **data
        )
        self.layout = Layout.of(bodies, [joint])
        (self.term,) = build([joint], self.layout)
        self.q, self.v = self.layout.q0.copy(), np.zeros(self.layout.ndof)
        self.coef = self.term.coefficients(self.temperatures())

    def temperatures(self, arm=AMBIENT, boom=AMBIENT):
        T = np.zeros((len(self.layout.x), 3))
        T[self.layout.point_index["arm"], 0] = arm
        T[self.layout.point_index["boom"], 0] = boom
        return T

    def vectors(self, q, name):
        """(n, 4, 3) view of the vectors of a body."""
        nodes = self.layout.node_dofs[name]
        return q[nodes[0] : nodes[-1] + 12].reshape(-1, 4, 3)

    def disturb(self, seed=3, size=0.004, speed=0.1, offset=(0.0, 0.012, -0.008)):
        rng = np.random.default_rng(seed)
        self.q += size * rng.standard_normal(self.q.size)
        self.v = speed * rng.standard_normal(self.q.size)
        self.vectors(self.q, "arm")[:, 0] += offset
        return self

    def run(self, approach=0.5, step=0.01, deflection=(0.0, 0.0, 0.0), since=0.0):
        """An impact and a step of time run."""
        self.coef[:, APPROACH], self.coef[:, STEP] = approach, step
        self.coef[:, HISTORY : HISTORY + 3] = deflection
        self.coef[:, HISTORY + 6] = since
        return self

    def force(self, q=None, v=None):
        out = np.zeros(self.q.size)
        q, v = self.q if q is None else q, self.v if v is None else v
        kernels.add_force(self.term, q, v, self.coef, out)
        return out

    def respond(self, q=None, v=None):
        q, v = self.q if q is None else q, self.v if v is None else v
        return kernels.responses(self.term, q, v, self.coef, COLUMNS)

    def remember(self):
        return kernels.histories(self.term, self.q, self.v, self.coef, HISTORIES)

    def energy(self, q):
        return kernels.energies(self.term, q, self.v, self.coef)[0]

    def matrix(self, cK, cC):
        K = np.zeros((self.q.size,) * 2)
        blocks = kernels.tangent_blocks(self.term, self.q, self.v, self.coef, cK, cC)
        for dofs, block in zip(self.term.pattern_dofs, blocks, strict=True):
            there = dofs >= 0
            K[np.ix_(dofs[there], dofs[there])] += block[np.ix_(there, there)]
        return K

    def row(self, label):
        return self.term.contact_names.index(f"sleeve.{label}")


def differences(function, x, step=1e-6):
    columns = []
    for i in range(x.size):
        e = np.zeros(x.size)
        e[i] = step
        columns.append((function(x + e) - function(x - e)) / (2.0 * step))
    return np.array(columns).T


def test_names_of_stations():
    term = Scene(inner=(0.5, 2.0, 3), stations=2).term
    assert term.contact_names == [
        "sleeve.node_00", "sleeve.node_01", "sleeve.node_02", "sleeve.station_00_1",
        "sleeve.station_00_2", "sleeve.station_01_1", "sleeve.station_01_2", "sleeve.mouth",
    ]  # fmt: skip
    assert term.slots == 1 and set(term.names) == {"sleeve"}
    assert len(term.pattern_dofs) == 7 * 3 + 2  # elements of the other tube


@pytest.mark.parametrize("mouth", ["start", "end"])
def test_feet_are_the_nearest_points(mouth):
    """Also of stations that have gone far, on bent axes; beyond the ends, on the end tangents."""
    scene = Scene(mouth=mouth)
    scene.disturb(size=0.02, offset=(-0.37, 0.03, 0.02))
    place = scene.respond()[:, PLACE]
    for row, station in enumerate(scene.term.stations):
        vectors, weights = station.vectors()
        p = weights[0] @ scene.q[vectors[:, None] + np.arange(3)]
        length = station.other.lengths[-1]
        if 0.0 < place[row] < length:
            body = scene.vectors(scene.q, station.other.body.name)

            def distance(s, p=p, body=body, lengths=station.other.lengths):
                return np.sum((p - hermite(s, body, lengths)) ** 2)

            start = min(np.linspace(0.0, length, 200), key=distance)
            found = minimize_scalar(
                distance, bounds=(max(start - 0.02, 0), min(start + 0.02, length)),
                method="bounded", options={"xatol": 1e-10},
            )  # fmt: skip
            assert place[row] == pytest.approx(found.x, abs=1e-7)
    inside = (place > 0.0) & (place < 1.2)
    assert 3 < inside.sum() < len(place)


def hermite(s, body, lengths):
    from scipy.interpolate import CubicHermiteSpline

    return CubicHermiteSpline(lengths, body[:, 0], body[:, 1])(s)


@pytest.mark.parametrize("where", ["inside", "at the rim"])
def test_normal_force_is_the_gradient_of_its_energy(where):
    scene = Scene(friction=None)
    scene.coef = scene.term.coefficients(
        scene.temperatures(boom=AMBIENT + np.array([0.0, 900.0, -2000.0, 400.0]))
    )
    scene.disturb(size=0.002)
    if where == "at the rim":
        scene.vectors(scene.q, "arm")[:, 0, 0] += 1.2 + 0.004 - scene.q[12]
        scene.vectors(scene.q, "boom")[:, 0, 0] -= scene.vectors(scene.q, "boom")[-1, 0, 0] - 1.2
        at = scene.respond()[scene.row("node_01")]
        assert at[PLACE] > 1.2 + 1e-3 and at[ELASTIC] > 0.0
        assert at[GAP] > CLEAR + 0.5 * (at[PLACE] - 1.2) ** 2 / (ROUNDING * RADIUS) * 0.5
    assert np.sum(scene.respond()[:, ELASTIC] > 0.0) >= 2
    slope = differences(scene.energy, scene.q)
    assert scene.force() == pytest.approx(slope, abs=1e-6 * np.abs(slope).max())
    assert np.abs(scene.force()).max() > 1.0


@pytest.mark.parametrize("law", LAWS)
def test_forces_of_stations_have_no_resultant(law):
    scene = Scene(friction=LAWS[law]).disturb().run(deflection=(1e-4, 2e-4, -1e-4), since=0.1)
    f, moment = np.zeros(3), np.zeros(3)
    out = scene.force()
    for name in ("arm", "boom"):
        x, g = scene.vectors(scene.q, name), scene.vectors(out, name)
        f += g[:, 0].sum(axis=0)
        moment += np.cross(x, g).sum(axis=(0, 1))
    assert np.abs(out).max() > 1.0
    assert np.abs(f).max() < 1e-11 * np.abs(out).max()
    assert np.abs(moment).max() < 1e-11 * np.abs(out).max()


@pytest.mark.parametrize("law", LAWS)
def test_power_is_that_of_normal_force_and_slip(law):
    scene = Scene(friction=LAWS[law]).disturb().run(deflection=(1e-4, 2e-4, -1e-4), since=0.1)
    r = scene.respond()
    normal = (r[:, ELASTIC] + r[:, DISSIPATIVE]) * r[:, DEPTH_RATE]
    friction = np.sum(r[:, FRICTION : FRICTION + 3] * r[:, SLIP : SLIP + 3], axis=1)
    assert scene.force() @ scene.v == pytest.approx(np.sum(normal - friction), rel=1e-12)
    assert (np.abs(friction).max() > 1e-3) == (law != "none")
    assert np.abs(r[:, DISSIPATIVE]).max() > 0.1


@pytest.mark.parametrize("rim", [False, True])
@pytest.mark.parametrize("law", LAWS)
def test_tangent(law, rim):
    """Against differences, in stick and slip, an impact, at nodes and between, beyond a rim."""
    scene = Scene(friction=LAWS[law]).disturb(size=0.002)
    scene.run(deflection=(1e-4, 2e-4, -1e-4), since=0.1)
    if rim:
        end = scene.vectors(scene.q, "boom")[-1, 0, 0]
        scene.vectors(scene.q, "arm")[:, 0, 0] += end + 0.004 - scene.q[12]
    r = scene.respond()
    touching = r[:, ELASTIC] > 0.0
    assert touching[scene.row("mouth")] and touching.sum() >= 2
    assert np.any(r[:, STUCK] > 0.0) == (law in ("stick", "lugre"))
    K = differences(lambda q: scene.force(q=q), scene.q)
    C = differences(lambda v: scene.force(v=v), scene.v)
    assert scene.matrix(1.0, 0.0) == pytest.approx(K, abs=2e-6 * np.abs(K).max())
    assert scene.matrix(0.0, 1.0) == pytest.approx(C, abs=2e-6 * np.abs(C).max())
    both = scene.matrix(1.0, 0.0) * 3.0 + scene.matrix(0.0, 1.0) * 7.0
    assert scene.matrix(3.0, 7.0) == pytest.approx(both, abs=1e-11 * np.abs(both).max())


def test_rates_of_the_response():
    scene = Scene().disturb()
    h = 1e-6
    before, after = (scene.respond(q=scene.q + t * scene.v) for t in (-h, h))
    now, there = scene.respond(), np.abs(scene.respond()[:, PATH]) > 0.0
    assert there.sum() >= 4
    rates = (after - before) / (2.0 * h)
    assert now[:, DEPTH_RATE][there] == pytest.approx(rates[:, DEPTH][there], abs=1e-7)
    for i in range(3):
        assert now[:, PATH_RATE + i][there] == pytest.approx(rates[:, PATH + i][there], abs=1e-7)


def test_no_jump_from_element_to_element():
    """The force on a bent axis changes steadily while a station passes a node."""
    scene = Scene(friction=None).disturb(size=0.003, offset=(0.0, 0.018, -0.01))
    arm = scene.vectors(scene.q, "arm")
    node, row, sides = scene.term.stations[0].other.lengths[2], scene.row("node_00"), []
    for _ in range(6):
        arm[:, 0, 0] -= (scene.respond()[row, PLACE] - node) / 1.01
    for shift in (-1e-8, 2e-8):
        arm[:, 0, 0] += shift
        sides.append((scene.respond()[row, PLACE], scene.force()))
    (before, left), (after, right) = sides
    assert node - 1e-7 < before < node < after < node + 1e-7
    assert np.abs(left[:12]).max() > 1.0
    assert left == pytest.approx(right, abs=1e-5 * np.abs(left).max())


def test_nothing_touches_outside():
    """Not even a tube that hangs down outside; the way out is steady, with no false contact."""
    scene = Scene()
    arm = scene.vectors(scene.q, "arm")
    arm[3:, 0, 1] -= 0.5
    r = scene.respond()
    outside = (r[:, PLACE] > 1.2 + 0.1) | (r[:, PLACE] < 0.0)
    assert outside.sum() >= 3 and np.all(r[outside, DEPTH] < -CLEAR)
    assert np.all(np.hypot.reduce(r[:, PATH : PATH + 3], axis=1) < r[:, GAP])
    assert not scene.force().any()
    arm[:] = scene.vectors(scene.layout.q0, "arm")
    arm[:, 0, 1] += CLEAR + 1e-3
    depths, row = [], scene.row("node_00")
    for _ in range(400):
        depths.append(scene.respond()[row, DEPTH])
        arm[:, 0, 0] += 2e-3
    assert depths[0] == pytest.approx(1e-3, rel=1e-4) and depths[-1] < -CLEAR
    leaving = np.array(depths)[np.array(depths) > -CLEAR]
    assert np.abs(np.diff(leaving)).max() < 5e-3


def test_slip_along_and_around():
    """Speed along the tube and R ω around it; none where both turn together."""
    scene = Scene()
    arm, v = scene.vectors(scene.q, "arm"), scene.vectors(scene.v, "arm")
    arm[:, 0, 1] += CLEAR + 1e-3
    v[:, 0, 0], spin = 0.2, 1.5
    v[:, 2], v[:, 3] = (0.0, 0.0, spin), (0.0, -spin, 0.0)
    at = scene.respond()[scene.row("node_01")]
    assert at[SLIP : SLIP + 3] == pytest.approx([0.2, 0.0, RADIUS * spin], abs=1e-12)
    mouth = scene.respond()[scene.row("mouth")]
    assert mouth[SLIP : SLIP + 3] == pytest.approx([0.2, 0.0, RADIUS * spin], abs=1e-12)
    pull = 0.3 * at[ELASTIC] / (np.hypot(0.2, RADIUS * spin) + 0.05)
    assert at[FRICTION] == pytest.approx(-pull * 0.2)
    assert at[FRICTION + 2] == pytest.approx(-pull * RADIUS * spin)
    omega = np.array([0.3, -0.4, 0.7])
    scene.v[:] = np.cross(omega, scene.q.reshape(-1, 3)).ravel()
    assert np.abs(scene.respond()[:, SLIP : SLIP + 3]).max() < 1e-12


def test_bristles_turn_with_the_tubes():
    """All forces turn with a structure that turns as a whole, those of bristles too."""
    scene = Scene(friction=LAWS["stick"]).disturb().run(deflection=(1e-4, 2e-4, -1e-4), since=0.1)
    turn = Rotation.from_rotvec([0.5, 1.1, -2.0])
    f, r, memory = scene.force(), scene.respond(), scene.remember()
    scene.q, scene.v = (turn.apply(x.reshape(-1, 3)).ravel() for x in (scene.q, scene.v))
    assert np.any(r[:, STUCK])
    assert scene.force() == pytest.approx(turn.apply(f.reshape(-1, 3)).ravel(), abs=1e-9)
    assert scene.respond()[:, FRICTION:] == pytest.approx(r[:, FRICTION:], abs=1e-9)
    assert scene.remember() == pytest.approx(memory, abs=1e-12)
    assert np.all(memory[r[:, STUCK] > 0.0, 6] == pytest.approx(0.11))
    assert not memory[r[:, ELASTIC] == 0.0].any()


def test_no_force_in_flight():
    scene = Scene().disturb()
    scene.coef[:, ACTIVE] = 0.0
    assert np.any(scene.respond()[:, DEPTH] > 0.0)
    assert not scene.force().any() and not scene.matrix(1.0, 1.0).any()
    assert scene.energy(scene.q) == 0.0


def test_statics_of_rigid_tubes():
    """Tip load: the moment about the inner end gives the mouth F L/a, the droop is of clearances.

    The inner tube of length L overlaps by a; it turns until both places touch, on opposite sides:
    2 c/a, so that the tip is at -c - (2 c/a) (L - a).
    """
    load, clearance, overlap, length = 40.0, 1e-3, 0.7, 2.0
    bodies = [tube("arm", 0.5, 2.5, 2), tube("boom", 0.0, 1.2, 3)]
    joint = Telescope(
        "sleeve", "arm", "boom", RADIUS, clearance, AMBIENT,
        contact=NormalContact("linear", 1e9),
    )  # fmt: skip
    layout = Layout.of(bodies, [joint])
    (term,) = build([joint], layout)
    coef = term.coefficients(np.full((len(layout.x), 3), AMBIENT))

    def placed(height, angle):
        """The arm rotated about its inner end, which is at a height."""
        q, turn = layout.q0.copy(), Rotation.from_rotvec([0.0, 0.0, angle])
        arm = q[: 2 * 12].reshape(2, 4, 3)
        arm[:] = turn.apply(arm.reshape(-1, 3)).reshape(2, 4, 3)
        arm[:, 0] += np.array([0.5, height, 0.0]) - arm[0, 0]
        return q

    def unbalanced(x):
        q, f = placed(*x), np.zeros(layout.ndof)
        kernels.add_force(term, q, 0.0 * q, coef, f)
        arm, g = q[:24].reshape(2, 4, 3), f[:24].reshape(2, 4, 3).copy()
        g[1, 0, 1] += load
        moment = np.cross(arm - [[arm[0, 0]], [arm[0, 0]]] * POSITIONS, g).sum(axis=(0, 1))
        return g[:, 0, 1].sum(), moment[2]

    start = clearance * 1.0001, -2.0 * clearance / overlap * 1.0001
    x, _, found, why = fsolve(unbalanced, start, full_output=True, xtol=1e-13)
    assert found == 1, why
    r = kernels.responses(term, placed(*x), np.zeros(layout.ndof), coef, COLUMNS)
    end, _, mouth = r[:, ELASTIC]
    assert mouth == pytest.approx(load * length / overlap, rel=2e-4)
    assert end == pytest.approx(load * (length - overlap) / overlap, rel=2e-4)
    droop = clearance + 2.0 * clearance / overlap * (length - overlap)
    assert placed(*x)[12 + 1] == pytest.approx(-droop, rel=2e-3)


POSITIONS = np.array([1.0, 0.0, 0.0, 0.0])[None, :, None]


def test_clearance_follows_both_temperatures():
    """Of the place where the tubes touch, not of where they did in the reference."""
    scene = Scene()
    boom = np.array([250.0, 300.0, 400.0, 350.0])
    T = scene.temperatures(arm=350.0, boom=boom)
    scene.coef = scene.term.coefficients(T)
    row, arm = scene.row("node_00"), scene.vectors(scene.q, "arm")
    for place in (0.2, 0.9):
        arm[:, 0, 0] += place - arm[0, 0, 0]
        bore = np.interp(place, [0.0, 0.4, 0.8, 1.2], boom) - AMBIENT
        gap = CLEAR + 17e-6 * bore * (RADIUS + CLEAR) - 23.1e-6 * (350.0 - AMBIENT) * RADIUS
        assert scene.respond()[row, GAP] == pytest.approx(gap, abs=1e-12)
    assert scene.coef[0, CLEARANCE] == pytest.approx(
        CLEAR + 17e-6 * (np.interp(0.55, [0.4, 0.8], [300.0, 400.0]) - AMBIENT) * 0.06
        - 23.1e-6 * (350.0 - AMBIENT) * RADIUS, abs=1e-12,
    )  # fmt: skip


def test_interference_holds_the_inner_tube():
    """Where no clearance is left the tubes press on each other, and hold each other along."""
    scene = Scene(friction=Friction(0.3, regularisation_speed=1e-6))
    hot = AMBIENT + (CLEAR + 1e-4) / (23.1e-6 * RADIUS)
    scene.coef = scene.term.coefficients(scene.temperatures(arm=hot))
    scene.vectors(scene.v, "arm")[:, 0, 0] = 0.1
    at = scene.respond()[scene.row("node_00")]
    assert at[GAP] == pytest.approx(-1e-4, rel=1e-9)
    assert at[ELASTIC] == pytest.approx(STIFFNESS * 1e-4**1.5, rel=1e-3)
    assert at[FRICTION] == pytest.approx(-0.3 * at[ELASTIC], rel=1e-4)
    assert np.all(np.isfinite(scene.matrix(1.0, 1.0)))


def test_friction_follows_the_mean_temperature():
    scene = Scene(friction=Friction(0.3, temperature_slope=1e-3, reference_temperature=300.0))
    boom = np.array([250.0, 300.0, 400.0, 350.0])
    coef = scene.term.coefficients(scene.temperatures(arm=350.0, boom=boom))
    at_nodes = coef[0, SLOT:].reshape(-1, 5)[:4, 2]
    mean = 0.5 * (350.0 + boom)
    assert at_nodes == pytest.approx(0.3 * (1.0 + 1e-3 * (mean - 300.0)), rel=1e-12)
    assert coef[0, KINETIC] == pytest.approx(np.interp(0.55, [0.4, 0.8], at_nodes[1:3]))


def test_heat_goes_to_the_nodes_about_the_contact():
    scene = Scene()
    T, work = scene.temperatures(), np.zeros(len(scene.term.stations))
    row, response = scene.row("station_00_1"), scene.respond()
    work[row] = 7.0
    assert response[row, PLACE] == pytest.approx(0.73125)
    heat = scene.term.deposit(T, work, response)
    roots = [np.sqrt(m * n * c) for m, n, c in ((167.0, 2700.0, 896.0), (16.2, 8000.0, 500.0))]
    to_arm = 7.0 * roots[0] / sum(roots)
    arm, boom = (scene.layout.point_index[name] for name in ("arm", "boom"))
    assert heat[arm] == pytest.approx([0.5 * to_arm, 0.5 * to_arm, 0, 0, 0], abs=1e-12)
    part = (0.73125 - 0.4) / 0.4
    assert heat[boom] == pytest.approx(
        [0.0, (7.0 - to_arm) * (1 - part), (7.0 - to_arm) * part, 0.0], abs=1e-12
    )
    work = np.random.default_rng(1).random(len(work))
    assert scene.term.deposit(T, work, response).sum() == pytest.approx(work.sum(), rel=1e-14)


def test_tubes_in_tubes_are_one_term():
    """Three tubes with unlike numbers of nodes and stations: as two terms, one for each joint."""
    bodies = [tube("arm", 0.8, 2.0, 6), tube("middle", 0.4, 1.5, 3), tube("boom", 0.0, 1.2, 5)]
    joints = [
        Telescope("first", "arm", "middle", RADIUS, CLEAR, AMBIENT, stations=2),
        Telescope("second", "middle", "boom", 2 * RADIUS, CLEAR, AMBIENT, mouth="start"),
    ]
    layout = Layout.of(bodies, joints)
    T = np.full((len(layout.x), 3), AMBIENT + 20.0)
    rng = np.random.default_rng(5)
    q = layout.q0 + 0.012 * rng.standard_normal(layout.ndof)
    v = rng.standard_normal(layout.ndof)

    def evaluated(chosen):
        (term,) = build(chosen, layout)
        coef, force = term.coefficients(T), np.zeros(layout.ndof)
        kernels.add_force(term, q, v, coef, force)
        matrix = np.zeros((layout.ndof + 1,) * 2)
        blocks = kernels.tangent_blocks(term, q, v, coef, 1.0, 0.5)
        for dofs, block in zip(term.pattern_dofs, blocks, strict=True):
            matrix[np.ix_(dofs, dofs)] += block
        r = kernels.responses(term, q, v, coef, COLUMNS)
        return term.contact_names, r, force, matrix[:-1, :-1]

    names, r, force, matrix = evaluated(joints)
    parts = [evaluated([joint]) for joint in joints]
    assert names == parts[0][0] + parts[1][0] and names[-1] == "second.mouth"
    assert r == pytest.approx(np.concatenate([part[1] for part in parts]))
    assert all(np.any(part[1][:, ELASTIC] > 0.0) for part in parts)
    assert force == pytest.approx(parts[0][2] + parts[1][2])
    assert matrix == pytest.approx(parts[0][3] + parts[1][3])


def test_masses_that_meet():
    """A node and the mouth, with a mass matrix of lumps: two masses, one after the other."""
    from scipy.sparse import csr_array

    scene = Scene(inner=(0.4, 2.0, 5))  # nodes stand .4 m apart, in both tubes
    mass = csr_array(np.diag(np.where(np.arange(scene.q.size) < 60, 2.0, 3.0)))
    masses = scene.term.masses(mass)
    assert masses[scene.row("node_00")] == pytest.approx(1.0 / (1 / 2.0 + 1 / 3.0))
    assert masses[scene.row("mouth")] == pytest.approx(1.0 / (1 / 2.0 + 1 / 3.0))


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"outer": "arm"}, "slide in itself"),
        ({"inner": "pole"}, "no body 'pole'"),
        ({"inner": "wire"}, "'wire' is no beam"),
        ({"inner": "aside"}, "'aside' is not inside 'boom'"),
        ({"mouth": "side"}, "'start' or 'end'"),
        ({"clearance": 0.0}, "positive"),
        ({"contact": NormalContact("linear")}, "needs its stiffness"),
        ({"friction": Friction(0.1, law="glue")}, "unknown friction"),
    ],
)
def test_what_cannot_be_made(changes, why):
    bodies = [
        tube("arm", 0.5, 2, 3), tube("boom", 0, 1.2, 3), tube("aside", 0.5, 2, 3, y=0.2),
        tube("wire", 0.5, 2, 3, element="cable"),
    ]  # fmt: skip
    data = {
        "name": "sleeve", "inner": "arm", "outer": "boom", "radius": RADIUS, "clearance": CLEAR,
        "reference_temperature": AMBIENT,
    }  # fmt: skip
    joint = Telescope(**data | changes)
    with pytest.raises(ValueError, match=f"joint 'sleeve'.*{why}"):
        build([joint], Layout.of(bodies, [joint]))


def test_a_seized_tube_is_braked():
    """Hot tubes press with K |c|^1.5 at two nodes and the mouth; the arm loses 3 μ N t in time t.

    What its motion loses is heat, at the nodes about the three places. The damping of the contacts
    is told its speed: none approaches another here, but for round-off.
    """
    hot, clearance, friction = AMBIENT + 60.0, 1e-5, Friction(0.3, regularisation_speed=1e-8)
    gap = clearance + 60.0 * (17e-6 * (RADIUS + clearance) - 23.1e-6 * RADIUS)
    stiffness = 6e8
    normal = stiffness * abs(gap) ** 1.5
    start = np.array([0.1, 0.0, 0.0])
    arm = replace(
        tube("arm", 0.5, 2.0, 3), section=ring(RADIUS - 2e-3, 4e-3), reference_temperature=hot,
        velocity=start,
    )  # fmt: skip
    boom = replace(
        tube("boom", 0.0, 1.3, 3, STEEL), section=ring(RADIUS + 2e-3, 4e-3),
        reference_temperature=hot,
    )  # fmt: skip
    joint = Telescope(
        "sleeve", "arm", "boom", RADIUS, clearance, AMBIENT,
        contact=NormalContact(value=stiffness, reference_speed=1.0), friction=friction,
    )  # fmt: skip
    base = Clamp("base", Site("boom", 0), Site(None))
    mechanics = Mechanics(
        Description([arm, boom], [base, joint]), Control(tolerance=1e-7, largest_step=5e-3)
    )
    T = np.zeros((len(mechanics.x), 3))
    T[:, 0] = hot
    state = mechanics.initial(T)
    mass = mechanics.system.mass[:36:12, :36:12].toarray().sum()
    time = 0.5 * mass * start[0] / (3.0 * 0.3 * normal)
    new, heat, why = mechanics.advance(state, time, T, T)
    assert gap < 0.0 and not why, why
    momentum = (mechanics.system.mass @ new.motion.v)[:36:12].sum()
    assert momentum == pytest.approx(0.5 * mass * start[0], rel=1e-4)
    assert heat.sum() == pytest.approx(0.375 * mass * start[0] ** 2, rel=1e-3)
    arm_points = mechanics.regions["arm"]
    assert np.all(heat[arm_points] > 0.0)


def test_energy_closes_while_a_node_leaves_the_tube():
    """A seized arm slides out under gravity; a node goes over the rim with the load it bears.

    What is lost is what the ledger says is lost: none of the energy of the contact vanishes.
    """
    hot = AMBIENT + 60.0
    options = {"damping_time": 1e-5, "reference_temperature": hot}
    arm = replace(
        tube("arm", 0.6355, 2.1355, 9), velocity=np.array([1.0, 0.0, 0.0]),
        section=ring(0.048, 4e-3),
        **options,
    )  # fmt: skip
    boom = replace(tube("boom", 0.0, 1.2, 5, STEEL), section=ring(0.052, 4e-3), **options)
    law = NormalContact(value=1e9, reference_speed=1.0)
    joint = Telescope("sleeve", "arm", "boom", RADIUS, 1e-5, AMBIENT, contact=law,
                      friction=Friction(0.3, law="stick"))  # fmt: skip
    base = Clamp("base", Site("boom", 0), Site(None))
    description = Description([arm, boom], [base, joint], gravity=np.array([0.0, -9.81, 0.0]))
    mechanics = Mechanics(description, Control(tolerance=1e-6, largest_step=1e-4))
    T, seen = np.full((len(mechanics.x), 3), [hot, 0.0, 0.0]), []
    row = mechanics.system.contact_names.index("sleeve.node_03")

    def observe(found):
        seen.append(found.response[:, row][:, [PLACE, ELASTIC]])

    state, _, why = mechanics.advance(mechanics.initial(T), 4e-3, T, T, observe)
    assert not why, why
    place, load = np.concatenate(seen).T
    assert load[place < 1.2].min() > 10.0 and load[-1] == 0.0
    assert np.sum(load[place > 1.2] > 0.0) > 1
    assert abs(state.ledger[DEFECT]) < 1e-6 * state.ledger[RUBBED]
    assert abs(state.ledger[NUMERICAL]) < 0.01 * state.ledger[CONTACT_ELASTIC]
