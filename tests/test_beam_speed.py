"""Speed of the default beam: times that depend on the machine, and ratios that do not."""

import time

import numpy as np
import pytest

from mechanics import beam3243, kernels
from mechanics.assembly import pattern
from mechanics.description import Beam
from mechanics.layout import Layout
from meshes.materials import constant_material
from meshes.sections import rectangle

BODIES, ELEMENTS = 144, 9
PLAIN = constant_material("plain", 2700.0, 70e9, 0.3, 23e-6, 160.0, 900.0)


def members(damping):
    """Term of as many elements as a ring of 36 bays has, its state and its places in a matrix."""
    rng = np.random.default_rng(0)
    points = np.zeros((ELEMENTS + 1, 3))
    points[:, 0] = np.linspace(0.0, 1.5, ELEMENTS + 1)
    axes = np.tile(np.eye(3), (ELEMENTS + 1, 1, 1))
    section = rectangle(0.03, 0.02)
    beams = [Beam(f"{i}", points, axes, section, PLAIN, 293.15, damping) for i in range(BODIES)]
    layout = Layout.of(beams)
    term = beam3243.build(beams, layout)
    q = layout.q0 + 0.01 * rng.standard_normal(layout.ndof)
    coef = term.coefficients(np.tile([300.0, 10.0, 0.0], (len(layout.x), 1)))
    shape, slots = pattern(layout.ndof, [(term.dofs, term.dofs)])
    places = slots[0].reshape(len(term.names), -1).astype(np.int64)
    return term, q, rng.standard_normal(q.size), coef, shape, places


def milliseconds(work, repeat=40):
    """Least processor time of a call."""
    times = []
    for _ in range(repeat):
        start = time.thread_time()
        work()
        times.append(time.thread_time() - start)
    return 1e3 * min(times)


@pytest.mark.benchmark
@pytest.mark.parametrize("damping", [0.0, 1e-3])
def test_time_of_forces_and_tangents(damping, capsys):
    """1296 elements: a tangent has 24 columns; differences of forces would cost 24 times theirs."""
    term, q, v, coef, shape, places = members(damping)
    out, data = np.zeros_like(q), shape.zeros()
    force = milliseconds(lambda: kernels.add_force(term, q, v, coef, out))
    tangent = milliseconds(lambda: kernels.add_tangent(term, q, v, coef, 1.0, 0.5, places, data))
    energy = milliseconds(lambda: kernels.energies(term, q, v, coef))
    dense = np.random.default_rng(0).standard_normal((len(term.names), 24, 24))
    product = milliseconds(lambda: np.matmul(dense, dense))
    with capsys.disabled():
        print(
            f"\n{len(term.names)} elements, damping time {damping} s: force {force:.2f} ms, "
            f"tangent {tangent:.2f} ms ({tangent / force:.1f} forces, "
            f"{tangent / product:.1f} products of 24 x 24 matrices), energy {energy:.2f} ms"
        )
    assert tangent < 16.0 * force
