"""The exact frame that meshes are compared with."""

import numpy as np
import pytest

from coupling.paper.exact_frame import Frame, Stuff, frame, member_stiffness
from meshes.sections import tube
from meshes.truss import ring_truss

TUBE = tube(0.05, 0.001, 0.33)
ALLOY = Stuff(69e9, 69e9 / 2.66, 2700.0, 23.1e-6)


def cantilever(length):
    held = np.zeros((6, 12))
    held[np.arange(6), np.arange(6)] = 1.0
    free = np.vstack([np.zeros((6, 6)), np.eye(6)])
    return Frame(
        ["bar"], np.array([length]), np.eye(3)[None], free, held, ["wall"] * 6, TUBE, ALLOY
    )


def test_static_stiffness_is_that_of_textbooks():
    L, K = 3.0, member_stiffness(0.0, 3.0, TUBE, ALLOY)
    EI, GA = ALLOY.E * TUBE.second_moment_2, TUBE.shear_factor_2 * ALLOY.G * TUBE.area
    shear = 12 * EI / (GA * L**2)  # Przemieniecki (1968), table 5.1
    assert K[0, 0] == pytest.approx(ALLOY.E * TUBE.area / L)
    assert K[1, 1] == pytest.approx(12 * EI / (L**3 * (1 + shear)))
    assert K[5, 5] == pytest.approx((4 + shear) * EI / (L * (1 + shear)))
    assert K[5, 11] == pytest.approx((2 - shear) * EI / (L * (1 + shear)))
    assert K[1, 5] == pytest.approx(6 * EI / (L**2 * (1 + shear)))
    assert K[2, 4] == pytest.approx(-6 * EI / (L**2 * (1 + shear)))


def test_slender_cantilever_has_the_frequencies_of_euler_and_bernoulli():
    L = 20.0
    wave = np.sqrt(ALLOY.E * TUBE.second_moment_2 / (ALLOY.density * TUBE.area))
    exact = np.array([1.8751041, 4.6940911]) ** 2 / L**2 * wave / (2 * np.pi)  # in two planes
    bar = cantilever(L)
    np.testing.assert_allclose(bar.frequencies([1, 2]), exact[[0, 0]], rtol=1e-4)
    assert [bar.below(2 * np.pi * f * exact[0]) for f in (0.99, 1.01)] == [0, 2]
    with pytest.raises(ValueError, match="single members"):
        bar.below(2 * np.pi * exact[1] * 1.2)


def test_free_expansion_of_a_ring_needs_no_forces():
    truss = ring_truss(6, 10.0, 2.0, 1, 0.0)
    made = frame(truss, TUBE, ALLOY)
    u, forces = made.heated(np.full(len(truss.members), 10.0))
    foot = next(m for m in truss.members if m.name == truss.corners[0][0]).points[0]
    for i, member in enumerate(truss.members):
        for k, end in enumerate((member.points[0], member.points[-1])):
            grown = ALLOY.expansion * 10.0 * (end - foot)
            np.testing.assert_allclose(u[i, k, :3], grown, atol=1e-10)
    assert max(forces.values()) < 1e-3  # of forces E A alpha dT of some 5000 N


def test_joints_transmit_what_holds_a_cooled_half():
    truss = ring_truss(6, 10.0, 2.0, 1, 0.0)
    made = frame(truss, TUBE, ALLOY)
    rises = np.array([-10.0 if 0 < m.angle < np.pi else 0.0 for m in truss.members])
    u, forces = made.heated(rises)
    np.testing.assert_allclose(made.rows @ u.ravel(), 0.0, atol=1e-12)
    twice, more = made.heated(2 * rises)
    np.testing.assert_allclose(twice, 2 * u, atol=1e-12)
    assert forces["support"] < 1e-6  # nothing pushes from outside
    assert max(more.values()) == pytest.approx(2 * max(forces.values()), rel=1e-6)
