"""Beams in a floating frame: linear theory in it, and where that departs from the true beam."""

from dataclasses import replace
from functools import partial
from operator import mul
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from slopes import expected_jacobian, force, jacobian, slopes

from coupling import casefile, simulation
from coupling.descriptions import motion_description
from coupling.errors import BadCase
from coupling.reading import Results
from coupling.verify.models import ROOM, bent, clamp, elastic, model, sections, straight
from mechanics import floating, kernels
from mechanics.description import Clamp, Description, Force, Revolute, Site
from mechanics.dynamics import Control, Window, advance, initial_state
from mechanics.layout import Layout
from mechanics.modes import modes
from mechanics.schemes import Scheme
from mechanics.solver import Mechanics
from mechanics.system import Factors, System
from meshes.generate import arc
from meshes.materials import constant_material
from meshes.sections import rectangle

BAR, SOFT = rectangle(0.02, 0.01), elastic(1e9, density=1000.0)
Y, Z = np.eye(3)[1:]


def beam(count=3, elements=8, section=BAR, material=SOFT, **more):
    return replace(straight(1.0, elements, section, material), modes=count, **more)


def parts(body):
    layout = Layout.of([body])
    term = floating.build(body, layout)
    return term, floating.holding([term], layout, layout.ndof), layout


def placed(layout, term, turn, shift, amplitudes):
    """Coordinates of the body with its frame turned and shifted, by the formula of the theory."""
    p = np.zeros(layout.kinds["beam@frame"] - 12)
    p[: len(amplitudes)] = amplitudes
    vectors = term.modes.places + term.modes.shapes @ p[: term.modes.shapes.shape[3]]
    vectors = vectors @ turn.T
    vectors[:, 0] += shift
    return np.concatenate([vectors.ravel(), shift, turn.T.ravel(), p])


# -- rigid motion, tangents ------------------------------------------------------------------------


def test_rigid_motion_makes_no_force_and_fulfils_the_ties():
    term, held, layout = parts(beam(3))
    turn = Rotation.from_rotvec([0.4, -1.2, 2.9]).as_matrix()
    q = placed(layout, term, turn, np.array([1.0, -2.0, 0.5]), [])
    y = np.concatenate([q, np.zeros(sum(h.rows for h in held))])
    coef = term.coefficients(np.tile([ROOM, 0.0, 0.0], (len(layout.x), 1)))
    assert np.abs(force(term, y, 0.0 * y, coef)).max() < 1e-9
    for other in held:
        assert np.abs(force(other, y, 0.0 * y, other.coefficients(None))).max() < 1e-13


def test_ties_hold_the_nodes_where_frame_and_modes_put_them():
    term, held, layout = parts(beam(3))
    turn = Rotation.from_rotvec([0.4, 0.3, -0.9]).as_matrix()
    amplitudes = 0.1 * np.random.default_rng(1).standard_normal(9)
    q = placed(layout, term, turn, np.array([0.1, 0.2, 0.3]), amplitudes)
    y = np.concatenate([q, np.zeros(sum(h.rows for h in held))])
    found = sum(force(h, y, 0.0 * y, h.coefficients(None)) for h in held)
    assert np.abs(found).max() < 1e-13
    y[layout.node_dofs["beam"][3] + 1] += 1e-3
    found = sum(force(h, y, 0.0 * y, h.coefficients(None)) for h in held)
    assert np.abs(found).max() == pytest.approx(1e-3)


def test_tangents():
    body = beam(0, elements=2, damping_time=0.3)
    term, held, layout = parts(body)
    random = np.random.default_rng(0)
    rows = sum(h.rows for h in held)
    y = np.concatenate([layout.q0, np.zeros(rows)]) + 0.3 * random.standard_normal(
        layout.ndof + rows
    )
    v = random.standard_normal(y.size)
    for other in held:
        coef = other.coefficients(None)
        found = jacobian(other, y, v, coef, -0.7, 0.4)
        expected = expected_jacobian(other, y, v, coef, -0.7, 0.4, layout.ndof)
        assert found == pytest.approx(expected, abs=1e-9)
    coef = term.coefficients(np.tile([ROOM + 30.0, 10.0, -20.0], (len(layout.x), 1)))
    block = kernels.tangent_blocks(term, y, v, coef, -0.7, 0.4)[0]
    at = term.pattern_dofs[0]
    K = slopes(lambda x: force(term, x, v, coef), y)[np.ix_(at, at)]
    C = slopes(lambda x: force(term, y, x, coef), v)[np.ix_(at, at)]
    assert block == pytest.approx(-0.7 * K + 0.4 * C, rel=1e-7, abs=1e-7 * np.abs(block).max())


# -- linear theory ---------------------------------------------------------------------------------

SLENDER = rectangle(2e-3, 1e-3)


def _roots(count):
    """Roots b of cos b cosh b = -1, of a cantilever."""
    middles = (np.arange(count) + 0.5) * np.pi
    middles[0] = 1.8
    return np.array([brentq(lambda b: np.cos(b) + 1.0 / np.cosh(b), m - 0.5, m + 0.5)
                     for m in middles])  # fmt: skip


def test_frequencies_are_those_of_linear_theory():
    made = model(beam(9, 12, SLENDER), [clamp()])
    system = made.system
    found = modes(system, system.layout.q0, np.zeros(system.m), made.coef, 4).frequencies
    soft, stiff = (np.sqrt(1e9 * h**2 / 12.0 / 1000.0) / (2.0 * np.pi) for h in (1e-3, 2e-3))
    b = _roots(3)
    expected = np.sort([*(b**2 * soft), *(b[:2] ** 2 * stiff)])[:4]
    assert found == pytest.approx(expected, rel=1e-3)


def test_frequencies_approach_those_of_the_mesh_from_above():
    def found(count):
        made = model(beam(count), [clamp()])
        system = made.system
        return modes(system, system.layout.q0, np.zeros(system.m), made.coef, 4).frequencies

    exact = found(None)
    errors = np.array([found(count) / exact - 1.0 for count in (0, 3, 9)])
    assert (errors > -1e-7).all() and (np.diff(errors, axis=0) < 0.0).all()
    assert errors[2].max() < 1e-3


@pytest.mark.parametrize(("load", "true"), [(1.0, 0.30172077), (2.0, 0.49345748)])
def test_elastica_is_that_of_linear_theory(load, true):
    """P L^3/3 EI whatever the load, without shortening; Bisshopp & Drucker (1945)."""

    def tip(count):
        section, material = rectangle(1e-3, 1e-3), elastic(1e9)
        push = load * 1e9 * section.second_moment_2
        made = model(
            beam(count, 8, section, material), [clamp()],
            [Force("tip", Site("beam", 8), Y, partial(mul, push))],
        )  # fmt: skip
        return made.position(bent(made).q, "beam", 8)

    assert tip(3) == pytest.approx([1.0, load / 3.0, 0.0], abs=1e-6)
    assert tip(None)[1] == pytest.approx(true, abs=1e-3)


def test_free_thermal_stretch_and_bow_are_exact():
    alpha, warmer, gradient = 2e-5, 50.0, 300.0
    material = elastic(1e9, expansion=alpha)
    made = model(beam(0, material=material), [clamp()])
    heated = made.system.coefficients(sections(made.system, ROOM + warmer, gradient))
    found = bent(made, heated=heated)
    stretch = 1.0 + alpha * warmer
    x = made.position(found.q, "beam", 8)
    assert x[0] == pytest.approx(stretch, abs=1e-6)
    assert x[1] == pytest.approx(-0.5 * alpha * gradient, rel=3e-3)  # the warmer side outwards
    y = np.append(found.q, np.zeros(made.system.m))
    assert made.system.energies(y, 0.0 * y, heated)[0] < 1e-12


def test_heated_between_clamps_it_pushes_with_EA_alpha_dT():
    material = elastic(1e9, expansion=2e-5)
    made = model(beam(3, material=material), [clamp(), Clamp("other", Site("beam", 8), Site(None))])
    heated = made.system.coefficients(sections(made.system, ROOM + 10.0))
    found = bent(made, heated=heated)
    term = made.system.elements[0]
    y = made.system.unknowns(found.q)
    N = term.resultants(y, 0.0 * y, heated[0])[:, 0]
    assert pytest.approx(-1e9 * BAR.area * 2e-5 * 10.0, rel=1e-3) == N


def test_end_moment_is_the_moment_everywhere():
    made = model(beam(0), [clamp()], [Force("tip", Site("beam", 8), Y, lambda s: 1e-3 * s)])
    found = bent(made)
    y = made.system.unknowns(found.q)
    resultants = made.system.elements[0].resultants(y, 0.0 * y, made.coef[0])
    middles = (np.arange(8) + 0.5) / 8.0
    assert resultants[:, 4] == pytest.approx(1e-3 * (1.0 - middles), rel=1e-6)
    assert resultants[:, 1] == pytest.approx(1e-3, rel=1e-6)


# -- motion ----------------------------------------------------------------------------------------


def _moved(made, end, tolerance=1e-7, largest=0.01, spectral=None):
    control = Control(tolerance, largest, 1e-9, Scheme("hht"))
    state, why = initial_state(made.system, control, made.coef)
    assert why == ""
    window = Window.between(made.system, 0.0, end, made.coef, None)
    found, _, why = advance(made.system, control, state, window)
    assert why == ""
    return state.motion, found.motion


def test_momentum_and_energy_of_a_free_body_remain():
    body = beam(3, velocity=np.array([0.3, 0.0, 0.1]), spin=np.array([0.0, 0.2, 3.0]))
    made = model(body)
    system, layout = made.system, made.system.layout
    first, last = _moved(made, 0.5)

    def moments(motion):
        p = (system.mass @ motion.v)[: layout.node_dofs["beam@frame"][0]].reshape(-1, 4, 3)
        x = motion.q[: p.size].reshape(-1, 4, 3)
        y = system.unknowns(motion.q)
        kinetic = 0.5 * motion.v @ (system.mass @ motion.v)
        energy = kinetic + system.energies(y, 0.0 * y, made.coef)[0]
        return np.concatenate([p[:, 0].sum(axis=0), np.cross(x, p).sum(axis=(0, 1)), [energy]])

    assert moments(last) == pytest.approx(moments(first), rel=1e-5, abs=1e-6)
    assert np.linalg.norm(last.q[:3] - first.q[:3]) > 0.1


def test_small_motion_is_that_of_the_true_beam_but_for_its_square():
    def tip(count, push):
        made = model(beam(count), [clamp()], [Force("tip", Site("beam", 8), Y, lambda t: push)])
        return made.position(_moved(made, 0.2)[1].q, "beam", 8)

    deflections, gaps = [], []
    for push in (0.5, 2.0):
        true, linear = tip(None, push), tip(12, push)
        deflections.append(true[1])
        gaps.append(abs(linear[1] - true[1]) / true[1])
        assert linear[0] == pytest.approx(1.0, abs=1e-5)
    assert deflections[1] > 0.1 and gaps[0] < 0.003
    assert gaps[1] / gaps[0] == pytest.approx(16.0, rel=0.3)


LENGTH, BENDING, LINE = 10.0, 1.0342e4, 1.0625
"""Of Kane, Ryan & Banerjee (1987), but for its section: EI [N m^2], mass [kg/m]."""
RAISE, RATE = 15.0, 6.0


def _rate(t):
    """Of the hub; its rate is RATE after RAISE."""
    s = np.minimum(t, RAISE) / RAISE
    return RATE * (s - np.sin(2.0 * np.pi * s) / (2.0 * np.pi))


def _angle(t):
    s = t / RAISE
    return RATE * RAISE * (0.5 * s**2 + (np.cos(2.0 * np.pi * s) - 1.0) / (2.0 * np.pi) ** 2)


def _spun(count, end):
    """Deflection of the tip [m] in the frame of the hub."""
    side = 0.02
    E = BENDING * 12.0 / side**4
    material = constant_material("arm", LINE / side**2, E, 0.0, 0.0, 1.0, 1.0)
    body = replace(straight(LENGTH, 6, rectangle(side, side), material), modes=count)
    hub = Revolute("hub", Site("beam", 0), Site(None), Z, angle=_angle)
    made = model(body, [hub])
    x = made.position(_moved(made, end, 1e-5, 0.05)[1].q, "beam", 6)
    return float(-np.sin(_angle(end)) * x[0] + np.cos(_angle(end)) * x[1])


def _linear_spun(end):
    """The same by vibrations of a cantilever, each softened by the rotation."""
    b = _roots(3)
    squares = (b**2) ** 2 * BENDING / (LINE * LENGTH**4)
    drive = 2.0 * LENGTH / b**2  # of x in shapes whose mean square is 1 and whose tip is 2

    def rates(t, y):
        acceleration = (_rate(t + 1e-5) - _rate(t - 1e-5)) / 2e-5
        return [*y[3:], *(-(squares - _rate(t) ** 2) * y[:3] - acceleration * drive)]

    found = solve_ivp(rates, (0.0, end), np.zeros(6), rtol=1e-9, atol=1e-9).y[:3, -1]
    return float(2.0 * found @ np.ones(3))


@pytest.mark.parametrize("end", [4.0, 7.0, 9.0])
def test_spin_up_softens_as_in_linear_theory(end):
    """Centrifugal forces act; the tension that would stiffen the beam does not."""
    assert _spun(6, end) == pytest.approx(_linear_spun(end), rel=0.02)


def test_the_true_beam_stiffens_in_the_spin_up():
    """Deflection of 0.57 m at most (Kane, Ryan & Banerjee 1987), where linear theory has left."""
    assert abs(_spun(None, 9.0)) < 0.6
    assert abs(_spun(6, 9.0)) > 2.0


def test_the_own_factorisation_serves_where_a_joint_holds_a_tied_node():
    """A joint repeats, in the eyes of its node, what ties it; it has to wait for the frame."""
    two = [replace(beam(9), name=name) for name in ("one", "other")]
    joints = [
        Revolute("hub", Site("one", 0), Site(None), Z),
        Revolute("elbow", Site("one", 8), Site("other", 0), Z),
    ]
    moved = replace(two[1], points=two[1].points + np.array([1.0, 0.0, 0.0]))
    system = model([two[0], moved], joints).system
    coef = system.coefficients(sections(system))
    y = system.unknowns(system.layout.q0)
    data = system.matrix(y, 0.0 * y, 0.0, coef, Factors(1e4, 1.0, 0.0))
    b = np.random.default_rng(0).standard_normal(y.size)
    work = system.solver._factors(data.copy())
    assert system.solver.name == "blocks" and work[0] == 0.0
    x = system.solver.factorise(data)(b)
    assert system.pattern.matrix(data) @ x == pytest.approx(b, abs=1e-6)


# -- what cannot be --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (beam(45), "'beam'.*8 elements have from 0 to 42 modes.*not 45"),
        (beam(-3), "not -3"),
        (beam(4), "by threes, not 4"),
        (beam(3, element="beam3243-enhanced"), "takes elements beam3243"),
    ],
)
def test_what_is_no_floating_frame_is_refused(body, message):
    with pytest.raises(ValueError, match=message):
        Mechanics(Description([body]), Control())


def test_rayleigh_damping_is_refused():
    with pytest.raises(ValueError, match=r"'beam'.*Rayleigh"):
        Mechanics(Description([beam(3)], rayleigh=(0.1, 0.0)), Control())


def test_a_free_frame_is_found_to_move():
    made = model(beam(3))
    from mechanics.mechanism import free_motions

    y = made.system.unknowns(made.system.layout.q0)
    assert "'beam'" in free_motions(made.system, y, made.coef)[0]


def test_systems_without_frames_have_none():
    system = System(Description([beam(None)]))
    assert system.m == 0 and set(system.layout.bodies) == {"beam"}


# -- in cases --------------------------------------------------------------------------------------

ARM = Path(__file__).parent.parent / "cases" / "arm_rotation"
FRAMED = 'body.arm.formulation="floating-frame"'


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ([FRAMED], "body.arm.modes: missing"),
        (["body.arm.modes=6"], "body.arm.modes: belongs to formulation"),
        ([FRAMED, "body.arm.modes=7"], "body.arm.modes: expected a multiple of 3, got 7"),
        ([FRAMED, "body.arm.modes=93"], "body.arm.modes: 16 elements have 90 at most, got 93"),
        ([FRAMED, "body.arm.modes=-3"], "body.arm.modes: expected an integer of at least 0"),
        (['body.arm.formulation="modal"', "body.arm.modes=6"], "body.arm.formulation"),
        (
            [FRAMED, "body.arm.modes=6", 'body.arm.element="beam3333"'],
            "body.arm.formulation: does not go with a beam of element beam3333",
        ),
        (
            [FRAMED, "body.arm.modes=6", 'mechanics.solver="continuum"'],
            "body.arm.formulation: a floating frame has modes of a beam",
        ),
    ],
)
def test_cases_with_impossible_frames_are_refused(changes, message):
    with pytest.raises(BadCase) as refused:
        casefile.read(ARM, changes)
    assert any(message in f"{p.path}: {p.text}" for p in refused.value.problems)


def test_a_cable_has_no_frame():
    changes = [FRAMED, "body.arm.modes=6", 'body.arm.kind="cable"']
    with pytest.raises(BadCase) as refused:
        casefile.read(ARM, changes)
    assert any("does not go with a cable" in p.text for p in refused.value.problems)


def test_a_hinge_with_play_heat_and_results_take_it_as_any_beam(tmp_path):
    tips = []
    for changes in ([], [FRAMED, "body.arm.modes=6"]):
        scene = casefile.read(ARM, [*changes, "time.end=0.3", "output.export=[]"])
        assert motion_description(scene).bodies[0].modes == (6 if changes else None)
        outcome = simulation.run(scene, tmp_path)
        assert outcome.code == 0
        with Results.open(outcome.folder) as results:
            assert "resultants" in results.names("bodies/arm")
            tips.append(results.table("probes/tip")["position"][-1, 1])
    assert tips[1] == pytest.approx(tips[0], rel=0.02) and tips[0] < -5e-4


def test_a_curved_body_vibrates_as_its_mesh():
    points, axes = arc(np.zeros(3), np.array([0.0, 1.0, 0.0]), Z, 0.5 * np.pi, 10)
    found = []
    for count in (None, 12):
        body = replace(beam(count, 10), points=points, axes=axes)
        system = model(body, [clamp()]).system
        coef = system.coefficients(sections(system))
        found.append(modes(system, system.layout.q0, np.zeros(system.m), coef, 4).frequencies)
    assert found[1] == pytest.approx(found[0], rel=5e-3)
