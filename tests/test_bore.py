"""A pin in the bore of a solid: balance, closed forms of pressure, heat, friction and impacts."""

from dataclasses import replace
from functools import cache

import bore_references as reference
import numpy as np
import pytest
from scipy.integrate import quad

from mechanics import kernels, march
from mechanics.bore import build
from mechanics.check import check
from mechanics.contact_laws import APPROACH, COLUMNS, HISTORY, KINETIC, RADIUS, SLOT, STEP
from mechanics.description import (
    BoreContact,
    Continuum,
    Description,
    Fixing,
    Force,
    Friction,
    Guide,
    Particle,
    Prismatic,
    ReferencePoint,
    Revolute,
    RigidBody,
    Site,
    Torque,
)
from mechanics.dynamics import Control
from mechanics.layout import Layout
from mechanics.march.program import MOMENT, WORK_DRIVE, WORK_THERMAL
from mechanics.solver import Mechanics
from mechanics.statics import equilibrium
from mechanics.system import System
from meshes.materials import constant_material
from meshes.solids import bore, pin

AMBIENT = 293.15
E, NU = 70e9, 0.3
ALUMINIUM = constant_material("aluminium", 2700.0, E, NU, 23e-6, 167.0, 896.0)
STEEL = constant_material("steel", 8000.0, 193e9, 0.29, 17e-6, 16.2, 500.0)
RADIUS_, CLEAR, LENGTH, OUTER = 0.01, 1e-4, 0.004, 0.02
AXIS, EAST = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
MIDDLE = 0.5 * LENGTH * AXIS
LAWS = {
    "none": None,
    "regularised": Friction(0.2),
    "stick": Friction(0.2, law="stick", presliding=1e-6),
    "lugre": Friction(0.2, law="lugre", presliding=1e-6, static_coefficient=0.3),
}


@cache
def mesh(around, layers=1, clearance=CLEAR, outer=OUTER, family="hexahedron20"):
    """A bush whose layers grow with the radius."""
    inner = RADIUS_ + clearance
    made = bore(inner, outer, LENGTH, around, layers, 1, family=family)
    r = np.hypot(made.points[:, 0], made.points[:, 1])
    levels = inner * (outer / inner) ** (np.arange(layers + 1) / layers)
    even = np.linspace(inner, outer, layers + 1)
    points = made.points.copy()
    points[:, :2] *= (np.interp(r, even, levels) / r)[:, None]
    return replace(made, points=points)


def bush(made):
    """The body, the facets of its bore, and distances from the axis."""
    family, members = made.regions["inner"]
    cells = next(c for name, c in made.cells.items() if name.startswith("hexa"))
    element = "hexahedron27" if cells.shape[1] == 27 else "hexahedron20-full"
    body = Continuum("bush", made.points, cells, ALUMINIUM, AMBIENT, element=element)
    return body, made.cells[family][members], np.hypot(*made.points[:, :2].T)


def held(nodes, directions=None):
    directions = np.eye(3) if directions is None else directions
    return [Fixing(f"hold_{i}_{len(directions)}_{int(directions[0].argmax())}", "bush", int(i),
                   "position", directions) for i in nodes]  # fmt: skip


def contact(facets, site, **changes):
    made = BoreContact(
        "joint", "bush", facets, site, AXIS, RADIUS_, 1e13, STEEL, ALUMINIUM, AMBIENT
    )
    return replace(made, **changes)


def at(place, *, clearance=CLEAR, around=32, **changes):
    """Response of a pin of the ground in a bush that keeps its shape, pressures and places."""
    body, facets, _ = bush(mesh(around, clearance=clearance))
    joint = contact(facets, Site(None, position=MIDDLE + place), **changes)
    layout = Layout.of([body], [joint])
    (term,) = build([joint], layout)
    T = np.tile([AMBIENT, 0.0, 0.0], (len(layout.x), 1))
    q = layout.q0
    response = kernels.responses(term, q, np.zeros_like(q), term.coefficients(T), COLUMNS)
    return response[0], term.pressures(response), term.facets.places


# -- balance, power and derivatives ------------------------------------------------------------


def disturbed(law, site, length, family):
    """A contact in a wild state: term, coefficients, coordinates, velocities, parts of the two."""
    body, facets, _ = bush(mesh(16, family=family))
    place = np.array([1.5 * CLEAR, 0.0, 0.5 * LENGTH])
    bodies = [body]
    if site == "rigid":
        bodies.append(RigidBody("pin", place, 0.1, 1e-4 * np.eye(3)))
        where = Site("pin")
    else:
        rod = pin(0.5 * RADIUS_, LENGTH, 8, 1, 1, family="hexahedron20")
        name, members = rod.regions["start"]
        face = np.unique(rod.cells[name][members])
        moved = rod.points + 1.5 * CLEAR * EAST + 0.5 * LENGTH * AXIS
        bodies.append(
            Continuum("rod", moved, rod.cells["hexahedron20"], STEEL, AMBIENT, "hexahedron20-full")
        )
        axes = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        bodies.append(ReferencePoint("rod@start", "rod", face, np.ones(len(face)), axes))
        where = Site("rod@start")
    joint = contact(facets, where, friction=LAWS[law], length=length, stiffness=1e12)
    layout, rng = Layout.of(bodies, [joint]), np.random.default_rng(7)
    (term,) = build([joint], layout)
    coef = term.coefficients(np.tile([300.0, 0.0, 0.0], (len(layout.x), 1)))
    each = coef.reshape(term.slots, -1)
    each[0, APPROACH], each[:, STEP] = 0.1, 1e-4
    each[:, HISTORY : HISTORY + 3] = 1e-7 * rng.standard_normal((term.slots, 3))
    first = layout.node_dofs[where.body][0]
    q = layout.q0 + 1e-6 * rng.standard_normal(layout.ndof)
    q[first + 3 :] += 1e-2 * rng.standard_normal(q.size - first - 3)
    v = 1e-2 * rng.standard_normal(q.size)
    return term, coef, q, v, first


def force(term, coef, q, v):
    out = np.zeros(q.size)
    kernels.add_force(term, q, v, coef, out)
    return out


wild = pytest.mark.parametrize(
    ("law", "site", "length", "family"),
    [
        *((law, "rigid", None, "hexahedron20") for law in LAWS),
        ("stick", "reference", 0.4 * LENGTH, "hexahedron20"),
        ("regularised", "rigid", 0.4 * LENGTH, "hexahedron27"),
    ],
)


@wild
def test_forces_and_moments_on_bore_and_pin_are_opposite(law, site, length, family):
    term, coef, q, v, first = disturbed(law, site, length, family)
    f = force(term, coef, q, v)
    pull, place = f.reshape(-1, 3), q.reshape(-1, 3)
    resultant = np.linalg.norm(pull[first // 3])
    assert resultant > 100.0
    on_bore = np.abs(np.cross(place[: first // 3], pull[: first // 3])).sum()
    vectors = 3 if site == "reference" else 4
    directions = np.cross(place[first // 3 + 1 :], pull[first // 3 + 1 :])
    moments = np.cross(place[: first // 3 + 1], pull[: first // 3 + 1]).sum(axis=0)
    moments += directions[: vectors - 1].sum(axis=0)
    total = pull[: first // 3 + 1].sum(axis=0)
    assert np.abs(total).max() < 1e-13 * np.abs(pull[: first // 3]).sum()
    assert np.abs(moments).max() < 1e-13 * on_bore


@wild
def test_power_is_that_of_pressure_and_friction(law, site, length, family):
    term, coef, q, v, _ = disturbed(law, site, length, family)
    response = kernels.responses(term, q, v, coef, COLUMNS)
    later = kernels.responses(term, q + 1e-7 * v, v, coef, COLUMNS)
    earlier = kernels.responses(term, q - 1e-7 * v, v, coef, COLUMNS)
    rate = (later[1:, march.GAP] - earlier[1:, march.GAP]) / 2e-7
    normal = response[1:, march.ELASTIC] + response[1:, march.DISSIPATIVE]
    rubbing = response[1:, march.FRICTION : march.FRICTION + 3]
    slip = response[1:, march.SLIP : march.SLIP + 3]
    power = normal @ rate - np.sum(rubbing * slip)
    assert force(term, coef, q, v) @ v == pytest.approx(power, rel=1e-7)
    assert np.sum(rubbing * slip) <= 0.0 or law == "stick"


@wild
def test_tangent_is_the_derivative(law, site, length, family):
    term, coef, q, v, _ = disturbed(law, site, length, family)
    cK, cC, eps = 2.0, 3.0, 1e-9
    way = np.random.default_rng(1).standard_normal(q.size)
    blocks, found = kernels.tangent_blocks(term, q, v, coef, cK, cC), np.zeros(q.size)
    for dofs, block in zip(term.pattern_dofs, blocks, strict=True):
        np.add.at(found, dofs, block @ way[dofs])
    high = force(term, coef, q + eps * cK * way, v + eps * cC * way)
    low = force(term, coef, q - eps * cK * way, v - eps * cC * way)
    assert np.abs(found - (high - low) / (2.0 * eps)).max() < 1e-7 * np.abs(found).max()


@pytest.mark.parametrize("length", [None, 0.4 * LENGTH])
def test_without_friction_and_impact_force_is_the_gradient_of_energy(length):
    term, coef, q, v, _ = disturbed("none", "rigid", length, "hexahedron20")
    way = np.random.default_rng(2).standard_normal(q.size)
    coef.reshape(term.slots, -1)[0, APPROACH] = 0.0
    high, low = (kernels.energies(term, q + s * way, v, coef)[0] for s in (1e-8, -1e-8))
    assert force(term, coef, q, v) @ way == pytest.approx((high - low) / 2e-8, rel=1e-6)


def test_rims_of_a_short_pin_lose_pressure_steadily():
    """Beyond the ends of the pin its surface recedes: by x²/(2 rim), without a jump."""
    push = np.array([1.5 * CLEAR, 0.0, 0.0])
    half = 0.1 * LENGTH
    whole, p, places = at(push)
    _, q, _ = at(push, length=2.0 * half)
    over = np.maximum(np.abs(places[..., 2] - MIDDLE[2]) - half, 0.0)
    expected = np.maximum(p - 1e13 * over**2 / (0.2 * RADIUS_), 0.0)
    assert np.abs(q - expected).max() < 1e-9 * p.max()
    assert whole[march.FLAT] == 1.0


# -- a bore that keeps its shape: Winkler's foundation -------------------------------------------


def depth(angle, place, clearance):
    return RADIUS_ - np.hypot((RADIUS_ + clearance) * np.cos(angle) - place,
                              (RADIUS_ + clearance) * np.sin(angle))  # fmt: skip


def foundation(place, clearance, stiffness):
    """Resultant, and integral of pressure [N]."""
    R = RADIUS_ + clearance
    cosine = (R**2 + place**2 - RADIUS_**2) / (2.0 * R * place)
    edge = np.pi if cosine < -1.0 else np.arccos(cosine)

    def resultant(t):
        x, y = R * np.cos(t) - place, R * np.sin(t)
        return depth(t, place, clearance) * x / np.hypot(x, y)

    forces = (quad(f, -edge, edge)[0] for f in (resultant, lambda t: depth(t, place, clearance)))
    return [stiffness * R * LENGTH * f for f in forces]


@pytest.mark.parametrize(
    ("place", "clearance", "around"),
    [(1.02e-4, 1e-4, 192), (1.5e-4, 1e-4, 48), (1e-3, 1e-4, 48), (5e-5, -1e-4, 48)],
)
def test_resultant_of_a_stiff_bore_is_that_of_the_foundation(place, clearance, around):
    """From a narrow contact to all round; the pressed region ends inside of facets."""
    whole, p, places = at(np.array([place, 0.0, 0.0]), clearance=clearance, around=around)
    expected = foundation(place, clearance, 1e13)
    tolerance = 2e-3 if clearance > 0.0 else 1e-4
    assert whole[[march.ELASTIC, march.PATH + 1]] == pytest.approx(expected, rel=tolerance)
    assert whole[march.DEPTH] == pytest.approx(place - clearance, rel=2e-2)
    angles = np.arctan2(places[..., 1], places[..., 0])
    closed = 1e13 * np.maximum(depth(angles, place, clearance), 0.0)
    assert np.abs(p - closed).max() < 1e-3 * closed.max()


def test_resultant_converges_with_the_mesh():
    expected = foundation(1.5e-4, CLEAR, 1e13)[0]
    errors = [
        abs(at(np.array([1.5e-4, 0.0, 0.0]), around=n)[0][march.ELASTIC] / expected - 1.0)
        for n in (8, 64)
    ]
    assert errors[1] < 1e-3 and errors[1] < 0.2 * errors[0]


def test_a_pressed_pin_bears_its_load():
    body, facets, r = bush(mesh(16))
    start = MIDDLE + 1.2 * CLEAR * EAST
    joint = contact(facets, Site("pin"))
    guide = Guide("guide", Site("pin"), np.eye(3)[1:])
    load = Force("load", Site("pin"), np.array([1.0, 0.0, 0.0]), lambda t: 800.0 * t)
    outside = held(np.flatnonzero(r > 0.999 * OUTER))
    bodies = [body, Particle("pin", start, 0.1)]
    system = System(Description(bodies, [*outside, joint, guide], [load]))
    coef = system.coefficients(np.tile([AMBIENT, 0.0, 0.0], (len(system.layout.x), 1)))
    found = equilibrium(system, coef, coef)
    assert found.why == ""
    y = system.unknowns(found.q)
    response = system.respond(y, np.zeros_like(y), coef)[0]
    assert response[march.ELASTIC] == pytest.approx(800.0, rel=1e-8)
    assert response[march.PATH + 1] > 800.0


# -- an elastic bore ---------------------------------------------------------------------------


def test_the_series_knows_the_closed_forms():
    """Persson for a rigid pin in an incompressible plane, Hertz where little touches."""
    nu, E_star = 0.4999999, E / (1.0 - 0.4999999**2)
    for b in (0.1, 0.3, 0.6):
        load = reference.similar(b, rigid=True) * E_star * CLEAR
        _, p, half = reference.pressed(load, RADIUS_, CLEAR, E, nu)
        assert half == pytest.approx(2.0 * np.arctan(b), abs=2.0 * np.pi / 720)
    load = 0.005 * E_star * CLEAR
    _, p, half = reference.pressed(load, RADIUS_, CLEAR, E, nu)
    width = np.sqrt(4.0 * load * RADIUS_**2 / CLEAR / np.pi / E_star)
    assert half * RADIUS_ == pytest.approx(width, rel=0.03)
    assert p.max() == pytest.approx(2.0 * load / (np.pi * width), rel=0.03)


def elastic(around, layers, place, clearance, stiffness):
    """Pressures and angles of a pin held at a place in a bush held outside; load [N/m]."""
    body, facets, r = bush(mesh(around, layers, clearance, 3.0 * RADIUS_))
    joint = contact(facets, Site(None, position=MIDDLE + place * EAST), stiffness=stiffness)
    rim = r > 3.0 * RADIUS_ * (1.0 - 1e-9)
    fixings = held(np.flatnonzero(rim)) + held(np.flatnonzero(~rim), np.eye(3)[2:])
    system = System(Description([body], [*fixings, joint]))
    coef = system.coefficients(np.tile([AMBIENT, 0.0, 0.0], (len(system.layout.x), 1)))
    found = equilibrium(system, coef, coef, steps=1, time=0.0)
    assert found.why == ""
    y, (term,) = system.unknowns(found.q), system.contacts
    response = system.respond(y, np.zeros_like(y), coef)
    places = term.facets.places
    angles = np.abs(np.arctan2(places[..., 1], places[..., 0])).ravel()
    return term.pressures(response).ravel(), angles, response[0, march.ELASTIC] / LENGTH


@pytest.mark.parametrize(
    ("around", "error"),
    [(24, 0.035), pytest.param(48, 0.008, marks=pytest.mark.slow)],
)
def test_pressure_in_an_elastic_bore_is_that_of_the_series(around, error):
    """Over 55° to each side: conformal, where Hertz says far too much. Error: root mean square."""
    clearance, stiffness = 1e-5, 2e14
    p, angles, load = elastic(around, 3, 2.4e-5, clearance, stiffness)
    t, exact, half = reference.pressed(
        load, RADIUS_ + clearance, clearance, E, NU, 3.0 * RADIUS_, stiffness
    )
    off = p - np.interp(angles, t, exact)
    assert np.sqrt(np.mean(off**2)) < error * exact.max()
    assert angles[p > 0.0].max() == pytest.approx(half, abs=2.0 * np.pi / around / 2.0)
    assert half > 0.9


@pytest.mark.slow
def test_penalty_converges_to_a_rigid_pin():
    """What a foundation gives way falls with its stiffness, until the mesh is felt."""
    errors = []
    for stiffness in (1e13, 4e13, 1.6e14):
        p, angles, load = elastic(48, 3, 2.4e-5, 1e-5, stiffness)
        t, exact, _ = reference.pressed(load, RADIUS_ + 1e-5, 1e-5, E, NU, 3.0 * RADIUS_)
        off = p - np.interp(angles, t, exact)
        errors.append(np.sqrt(np.mean(off**2)) / exact.max())
    assert errors[0] > 1.5 * errors[1] > 2.0 * errors[2]
    assert errors[2] < 0.02


# -- temperature -------------------------------------------------------------------------------


def temperatures(system, pin_above):
    T = np.tile([AMBIENT, 0.0, 0.0], (len(system.layout.x), 1))
    T[system.layout.point_index["joint.journal"], 0] += pin_above
    return T


def test_a_hot_pin_seizes_where_its_growth_is_the_clearance():
    body, facets, _ = bush(mesh(32))
    joint = contact(facets, Site(None, position=MIDDLE))
    layout = Layout.of([body], [joint])
    (term,) = build([joint], layout)
    limit = CLEAR / (17e-6 * RADIUS_)
    for factor, touches in ((0.9995, False), (1.0005, True)):
        T = np.tile([AMBIENT, 0.0, 0.0], (len(layout.x), 1))
        T[layout.point_index["joint.journal"], 0] += factor * limit
        q, coef = layout.q0, term.coefficients(T)
        response = kernels.responses(term, q, np.zeros_like(q), coef, COLUMNS)
        assert coef[0, RADIUS] == pytest.approx(RADIUS_ * (1.0 + 17e-6 * factor * limit))
        assert (response[0, march.DEPTH] > 0.0) == touches
        assert np.all((response[1:, march.ELASTIC] > 0.0) == touches)


def lame(pin_above, bush_above, clearance, stiffness):
    """Pressure of a pin that grows in a thick cylinder of plane strain, free outside."""
    a, b = RADIUS_ + clearance, OUTER
    # plane strain: free growth across is (1 + ν) α ΔT
    hole = a * (1.0 + NU) * 23e-6 * bush_above
    over = RADIUS_ * 17e-6 * pin_above - clearance - hole
    give = (1.0 + NU) / E * a * ((1.0 - 2.0 * NU) * a**2 + b**2) / (b**2 - a**2)
    return over / (give + 1.0 / stiffness)


@pytest.mark.parametrize(("pin_above", "bush_above"), [(100.0, 0.0), (80.0, 10.0)])
def test_pressure_of_a_seized_pin_is_that_of_lame(pin_above, bush_above):
    clearance, stiffness = 5e-6, 5e13
    body, facets, _ = bush(mesh(32, 2, clearance))
    joint = contact(facets, Site(None, position=MIDDLE), stiffness=stiffness)
    on_x, on_y = (np.flatnonzero(np.abs(body.points[:, k]) < 1e-9) for k in (1, 0))
    flat = np.eye(3)
    fixings = [
        *held(on_x, flat[1:2]), *held(on_y, flat[:1]), *held(range(len(body.points)), flat[2:])
    ]  # fmt: skip
    system = System(Description([body], [*fixings, joint]))
    T = temperatures(system, pin_above)
    T[system.layout.point_index["bush"], 0] += bush_above
    found = equilibrium(system, system.coefficients(T), system.coefficients(T), steps=1)
    assert found.why == ""
    y, coef = system.unknowns(found.q), system.coefficients(T)
    (term,) = system.contacts
    p, part = term.pressures(system.respond(y, np.zeros_like(y), coef)), term.facets.areas
    part = part / part.sum()
    # facets of the second degree lie a little inside of the circle
    gap = np.sum(part * np.hypot(*term.facets.places[..., :2].T).T) - RADIUS_
    assert gap == pytest.approx(clearance, abs=2e-6 * RADIUS_)
    expected = lame(pin_above, bush_above, gap, stiffness)
    assert np.sum(part * p) == pytest.approx(expected, rel=2e-3)
    assert np.ptp(p) < stiffness * 2e-5 * RADIUS_


# -- friction and its heat -----------------------------------------------------------------------


def turning(law, stiff=False, torque=None, around=16, load=500.0, omega=50.0):
    """A pin that is pressed by a carriage and turned by it, and its temperatures."""
    body, facets, r = bush(mesh(around))
    start = MIDDLE + CLEAR * EAST
    spin = np.array([0.0, 0.0, 0.0 if torque else omega])
    bodies = [
        body,
        RigidBody("cart", start, 0.02, 1e-6 * np.eye(3)),
        RigidBody("pin", start, 0.02, 1e-6 * np.eye(3), spin=spin),
    ]
    angle = None if torque else lambda t: omega * t
    nodes = range(len(r)) if stiff else np.flatnonzero(r > 0.999 * OUTER)
    joints = [
        *held(nodes),
        contact(facets, Site("pin"), friction=law, restitution=0.3),
        Revolute("drive", Site("pin"), Site("cart"), AXIS, angle=angle),
        Prismatic("slide", Site("cart"), Site(None, position=start), np.eye(3)[0]),
    ]
    loads = [Force("load", Site("cart"), np.eye(3)[0], lambda t: load)]
    if torque:
        loads.append(Torque("torque", Site("pin"), Site("cart"), AXIS, torque))
    made = Mechanics(Description(bodies, joints, loads), Control(1e-6, 1e-4))
    return made, np.tile([AMBIENT, 0.0, 0.0], (len(made.x), 1))


@pytest.mark.parametrize("law", ["regularised", "stick"])
def test_heat_of_a_turning_pin_is_torque_times_angle(law):
    """Torque μ ∫p dA R, work of the drive, heat and friction in the ledger are the same."""
    made, T = turning(LAWS[law])
    state, _, why = made.advance(made.initial(T), 4e-3, T, T)
    assert why == ""
    before, rows = state.ledger, []
    state, heat, why = made.advance(state, 4e-3, T, T, observe=rows.append)
    assert why == ""
    response = np.concatenate([r.response[:, 0] for r in rows])
    pressed, torque = response[:, march.PATH + 1].mean(), -response[:, MOMENT].mean()
    assert torque == pytest.approx(0.2 * pressed * RADIUS_, rel=1e-3)
    assert heat.sum() == pytest.approx(torque * 50.0 * 4e-3, rel=1e-4)
    assert heat.sum() == pytest.approx(0.2 * pressed * RADIUS_ * 50.0 * 4e-3, rel=1e-3)
    change = state.ledger - before
    assert heat.sum() == pytest.approx(change[march.RUBBED], rel=1e-13)
    assert change[WORK_DRIVE] == pytest.approx(heat.sum(), rel=1e-4)
    assert abs(change[march.DEFECT]) < 1e-8 * heat.sum()
    assert abs(change[march.NUMERICAL]) < 1e-4 * heat.sum()
    assert response[-1, march.SLIP] == pytest.approx(50.0 * RADIUS_, rel=1e-3)


def test_heat_is_shared_by_effusivity_and_lies_where_the_pin_rubs():
    made, T = turning(LAWS["regularised"], stiff=True)
    _, heat, _ = made.advance(made.initial(T), 2e-3, T, T)
    pin, bush_ = heat[made.regions["joint.journal"]].sum(), heat[made.regions["bush"]]
    effusivity = [np.sqrt(m.conductivity(AMBIENT) * m.density * m.heat_capacity(AMBIENT))
                  for m in (STEEL, ALUMINIUM)]  # fmt: skip
    assert pin / heat.sum() == pytest.approx(effusivity[0] / sum(effusivity), rel=1e-12)
    assert pin + bush_.sum() == pytest.approx(heat.sum(), rel=1e-14)
    points = made.x[made.regions["bush"]]
    angle = np.abs(np.arctan2(points[:, 1], points[:, 0]))
    inner = np.hypot(points[:, 0], points[:, 1]) < RADIUS_ + 1.1 * CLEAR
    assert np.abs(bush_[~inner]).max() == 0.0
    assert np.abs(bush_[angle > np.pi / 3.0]).max() == 0.0
    assert bush_ @ points[:, 0] / bush_.sum() > 0.9 * RADIUS_
    assert bush_ @ points[:, 1] / bush_.sum() == pytest.approx(0.0, abs=1e-3 * RADIUS_)


def test_shares_follow_the_temperature_at_each_point():
    body, facets, _ = bush(mesh(16))
    joint = contact(facets, Site(None, position=MIDDLE), friction=LAWS["regularised"])
    layout = Layout.of([body], [joint])
    (term,) = build([joint], layout)
    T = np.tile([AMBIENT, 0.0, 0.0], (len(layout.x), 1))
    work = np.random.default_rng(3).random(term.slots)
    work[0] = 0.0
    T[:, 0] += 50.0 * np.random.default_rng(4).random(len(T))
    heat = term.deposit(T, work, np.zeros((term.slots, COLUMNS)))
    assert heat.sum() == pytest.approx(work.sum(), rel=1e-13)


def test_coefficient_follows_the_mean_of_pin_and_bore():
    body, facets, _ = bush(mesh(16))
    law = Friction(0.2, temperature_slope=0.01, reference_temperature=AMBIENT)
    joint = contact(facets, Site(None, position=MIDDLE), friction=law)
    layout = Layout.of([body], [joint])
    (term,) = build([joint], layout)
    T = np.tile([AMBIENT, 0.0, 0.0], (len(layout.x), 1))
    T[layout.point_index["bush"], 0] += 1e3 * layout.x[layout.point_index["bush"], 0]
    T[layout.point_index["joint.journal"], 0] += 30.0
    found = term.coefficients(T).reshape(-1, SLOT)[1:, KINETIC]
    bore_above = 1e3 * term.facets.places[..., 0].ravel()
    assert found == pytest.approx(0.2 * (1.0 + 0.005 * (30.0 + bore_above)), rel=1e-9)


def angles(made, state):
    q = state.motion.q
    first = made.system.layout.node_dofs["pin"][0]
    return float(np.arctan2(q[first + 4], q[first + 3]))


def test_a_pin_sticks_below_the_bound_and_does_not_creep():
    """With a law of stick the turn stays within the presliding; above μ ∫p dA R it slides."""
    limit = 0.2 * 500.0 * RADIUS_
    for part, holds in ((0.8, True), (1.2, False)):
        law = Friction(0.2, law="stick", presliding=1e-6, bristle_damping=10.0)
        made, T = turning(
            law,
            stiff=True,
            around=12,
            torque=lambda t, part=part: part * limit * min(t / 2e-3, 1.0),
        )
        state, _, why = made.advance(made.initial(T), 2.5e-3, T, T)
        assert why == ""
        middle = angles(made, state)
        rows = []
        state, _, why = made.advance(state, 5e-4, T, T, observe=rows.append)
        assert why == ""
        moved = abs(angles(made, state) - middle) * RADIUS_
        assert (moved < 1e-9) == holds  # creeping would be 2e-7 m
        assert (rows[-1].response[-1, 0, march.STUCK] == 1.0) == holds


def test_a_growing_pin_does_work_that_the_ledger_knows():
    made, T = turning(LAWS["regularised"], stiff=True)
    state, _, _ = made.advance(made.initial(T), 2e-3, T, T)
    before, hot = state.ledger, T.copy()
    hot[made.regions["joint.journal"], 0] += 20.0
    state, heat, why = made.advance(state, 2e-3, T, hot)
    change = state.ledger - before
    assert why == ""
    assert change[WORK_THERMAL] > 0.0
    assert abs(change[march.DEFECT]) < 1e-8 * change[march.RUBBED]
    assert heat.sum() == pytest.approx(change[march.RUBBED], rel=1e-13)


# -- impacts -----------------------------------------------------------------------------------


def thrown(restitution, stiff, speed=0.1):
    """Speed of a pin after one crossing of the bore and one impact, in that before; its ledger."""
    body, facets, r = bush(mesh(16))
    thrown_ = RigidBody("pin", MIDDLE, 0.02, 1e-6 * np.eye(3), velocity=np.eye(3)[0] * speed)
    nodes = range(len(r)) if stiff else np.flatnonzero(r > 0.999 * OUTER)
    joint = contact(facets, Site("pin"), restitution=restitution)
    made = Mechanics(Description([body, thrown_], [*held(nodes), joint]), Control(1e-6, 1e-4))
    T = np.tile([AMBIENT, 0.0, 0.0], (len(made.x), 1))
    state = made.initial(T)
    energy = state.ledger[:3].sum()
    state, _, why = made.advance(state, 1.5e-3, T, T)
    assert why == ""
    first = made.system.layout.node_dofs["pin"][0]
    return state.motion.v[first] / speed, state.ledger / energy


@pytest.mark.parametrize("restitution", [1.0, 0.6])
def test_a_stiff_bore_returns_the_restitution(restitution):
    speed, ledger = thrown(restitution, stiff=True)
    assert speed == pytest.approx(-restitution, rel=2e-3)
    assert ledger[march.HYSTERESIS] == pytest.approx(1.0 - restitution**2, abs=2e-3)
    assert abs(ledger[march.DEFECT]) < 1e-7


@pytest.mark.parametrize("restitution", [1.0, 0.6])
def test_an_elastic_bore_gives_no_energy(restitution):
    """It returns more than the contact on its own, since it takes a part without loss."""
    speed, ledger = thrown(restitution, stiff=False)
    assert -1.0 < speed < -restitution + 5e-3
    assert ledger[: march.CONTACT_ELASTIC + 1].sum() <= 1.0
    assert ledger[march.NUMERICAL] >= -1e-6
    assert abs(ledger[march.DEFECT]) < 1e-7


def test_bore_and_pin_keep_their_momentum():
    """A free bush and a free pin that spins: momentum and moment of momentum after impacts."""
    body, facets, _ = bush(mesh(16))
    body = replace(body, spin=np.array([0.0, 0.0, 5.0]))
    start = MIDDLE + 0.5 * CLEAR * EAST
    flying = RigidBody("pin", start, 0.02, 1e-6 * np.eye(3),
                       velocity=np.array([0.1, 0.05, 0.0]), spin=40.0 * AXIS)  # fmt: skip
    joint = contact(facets, Site("pin"), friction=LAWS["stick"], restitution=0.7)
    made = Mechanics(Description([body, flying], [joint]), Control(1e-6, 1e-4))
    T = np.tile([AMBIENT, 0.0, 0.0], (len(made.x), 1))
    state = made.initial(T)
    old = momenta(made, state)
    state, heat, why = made.advance(state, 2e-3, T, T)
    assert why == ""
    assert heat.sum() > 0.0
    for one, other, size in zip(old, momenta(made, state), (2e-3, 1e-4), strict=True):
        assert np.abs(one - other).max() < 1e-6 * size


def momenta(made, state):
    q, v = state.motion.q.reshape(-1, 3), state.motion.v
    p = (made.system.mass @ v).reshape(-1, 3)
    bodies = made.system.layout.node_dofs
    places = np.concatenate([bodies["bush"] // 3, bodies["pin"] // 3])
    return p[places].sum(axis=0), np.cross(q, p).sum(axis=0)


# -- start in equilibrium ------------------------------------------------------------------------


@pytest.mark.parametrize("gap", [1.0, 0.0])
def test_motion_begins_with_the_pin_pressed(gap):
    """From any gap the pin falls to where the bore carries 500 N, and stays there: no waves."""
    body, facets, r = bush(mesh(24))
    start = MIDDLE + (1.0 - gap) * CLEAR * EAST
    joints = [
        *held(np.flatnonzero(r > 0.999 * OUTER)),
        contact(facets, Site("pin"), restitution=0.3),
        Prismatic("slide", Site("pin"), Site(None, position=start), EAST),
    ]
    loads = [Force("load", Site("pin"), EAST, lambda t: 500.0)]
    bodies = [body, RigidBody("pin", start, 0.02, 1e-6 * np.eye(3))]
    made = Mechanics(Description(bodies, joints, loads), Control(1e-6, 1e-4))
    T = np.tile([AMBIENT, 0.0, 0.0], (len(made.x), 1))
    state = made.initial(T, rest=T)
    rows: list = []
    after, _, why = made.advance(state, 1e-3, T, T, observe=rows.append)
    assert why == ""
    pressed = np.concatenate([row.response[:, 0, march.PATH + 1] for row in rows])
    assert rows[0].response[:, 0, march.ELASTIC] == pytest.approx(500.0, rel=1e-6)
    assert np.ptp(pressed) < 1e-6 * pressed[0]
    assert np.abs(after.motion.q - state.motion.q).max() < 1e-13
    assert after.counts[0] <= 12  # 400 from a sudden load, which sends waves through the ring


def test_a_loose_pin_that_nothing_pushes_has_no_equilibrium():
    body, facets, _ = bush(mesh(16))
    joints = [
        *held(range(len(body.points))),
        contact(facets, Site("pin")),
        Prismatic("slide", Site("pin"), Site(None, position=MIDDLE), EAST),
    ]
    bodies = [body, RigidBody("pin", MIDDLE, 0.02, 1e-6 * np.eye(3))]
    made = Mechanics(Description(bodies, joints), Control(1e-6, 1e-4))
    T = np.tile([AMBIENT, 0.0, 0.0], (len(made.x), 1))
    with pytest.raises(ValueError, match="nothing holds body 'pin': it can move along x"):
        made.initial(T, rest=T)


# -- what cannot be ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"body": "pin"}, "no solid body"),
        ({"facets": np.zeros((2, 4), int)}, "8 or 9 nodes"),
        ({"facets": np.full((1, 8), 10**6)}, "its facets others"),
        ({"stiffness": 0.0}, "positive"),
        ({"restitution": 0.0}, "restitution"),
        ({"dissipation": "lost"}, "lost"),
        ({"friction": Friction(0.2, law="oil")}, "oil"),
        ({"length": -1.0}, "positive"),
    ],
)
def test_what_cannot_be_built_is_said(changes, words):
    body, facets, _ = bush(mesh(16))
    bodies = [body, Particle("pin", MIDDLE, 1.0)]
    joint = replace(contact(facets, Site("pin")), **changes)
    with pytest.raises(ValueError, match=words):
        build([joint], Layout.of(bodies, [joint]))


def test_bad_numbers_are_found_before_anything_is_built():
    body, facets, _ = bush(mesh(16))
    joint = contact(facets, Site("nobody"), pin_radius=-1.0, axis=np.zeros(3))
    found = " ".join(check(Description([body], [joint])))
    for words in ("pin radius", "no body 'nobody'", "axis has no direction"):
        assert words in found
