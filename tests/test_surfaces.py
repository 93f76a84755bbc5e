"""Surfaces from few numbers: places, derivatives, areas and numbering."""

import numpy as np
import pytest

from meshes.surfaces import annulus, patch, placed, plate, sphere, tube

QUARTER = (0.0, 0.5 * np.pi)
SURFACES = {
    "plate": plate(2.0, 0.7, 3, 5),
    "tube": tube(0.3, 1.1, 16, 3),
    "panel": tube(0.3, 1.1, 5, 3, (-0.4, 0.9)),
    "annulus": annulus(0.6, 1.0, 2, 24),
    "sector": annulus(0.6, 1.0, 3, 4, QUARTER),
    "sphere": sphere(0.8, 16, 12, (-1.2, 1.2)),
    "octant": sphere(0.8, 5, 6, (0.1, 1.3), QUARTER),
}
AREA = {
    "plate": 1.4,
    "tube": 2 * np.pi * 0.3 * 1.1,
    "panel": 1.3 * 0.3 * 1.1,
    "annulus": np.pi * (1.0 - 0.36),
    "sector": 0.25 * np.pi * (1.0 - 0.36),
    "sphere": 2 * np.pi * 0.64 * 2 * np.sin(1.2),
    "octant": 0.5 * np.pi * 0.64 * (np.sin(1.3) - np.sin(0.1)),
}
GAUSS = 0.5 + 0.5 * np.polynomial.legendre.leggauss(5)[0]
WEIGHT = 0.5 * np.polynomial.legendre.leggauss(5)[1]
named = pytest.mark.parametrize("name", SURFACES)


def hermite(x):
    """(n, 2 ends, value and slope) and its derivative."""
    values = [
        [(1 - x) ** 2 * (1 + 2 * x), x * (1 - x) ** 2],
        [x * x * (3 - 2 * x), x * x * (x - 1)],
    ]
    slopes = [[6 * x * (x - 1), 1 - 4 * x + 3 * x * x], [6 * x * (1 - x), 3 * x * x - 2 * x]]
    return np.array(values).transpose(2, 0, 1), np.array(slopes).transpose(2, 0, 1)


def interpolated(surface, u, v):
    """r, r_u, r_v (n_e, n, n, 3) at fractions u, v of all elements, by bicubic Hermite."""
    a, b = surface.sizes.T[:, :, None, None]
    nodal = np.stack([surface.points, surface.d_u, surface.d_v, surface.d_uv], axis=1)
    corner = nodal[surface.quads].copy()
    corner[:, :, 1] *= a
    corner[:, :, 2] *= b
    corner[:, :, 3] *= a * b
    grid = np.empty((len(corner), 2, 2, 2, 2, 3))  # end and order in u, end and order in v
    for k, (i, j) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
        grid[:, i, :, j] = corner[:, k].reshape(-1, 2, 2, 3).swapaxes(1, 2)
    (Hu, dHu), (Hv, dHv) = hermite(u), hermite(v)
    r, ru, rv = (
        np.einsum("gia,hjb,eiajbk->eghk", U, V, grid) for U, V in ((Hu, Hv), (dHu, Hv), (Hu, dHv))
    )
    return r, ru / a[..., None], rv / b[..., None]


@named
def test_area_and_normal(name):
    surface = SURFACES[name]
    r, ru, rv = interpolated(surface, GAUSS, GAUSS)
    cross = np.cross(ru, rv)
    density = np.einsum("g,h,eghk,eghk->e", WEIGHT, WEIGHT, cross, _outward(name, r))
    assert np.sum(density * surface.sizes.prod(axis=1)) == pytest.approx(AREA[name], rel=2e-4)


def _outward(name, r):
    if name in ("plate", "annulus", "sector"):
        return np.broadcast_to([0.0, 0.0, 1.0], r.shape)
    flat = r * [1.0, 1.0, float(name in ("sphere", "octant"))]
    return flat / np.linalg.norm(flat, axis=-1, keepdims=True)


@named
def test_interpolation_is_on_the_surface(name):
    r = interpolated(SURFACES[name], GAUSS, GAUSS)[0]
    if name in ("tube", "panel"):
        np.testing.assert_allclose(np.hypot(r[..., 0], r[..., 1]), 0.3, rtol=1e-4)
    elif name in ("sphere", "octant"):
        np.testing.assert_allclose(np.linalg.norm(r, axis=-1), 0.8, rtol=1e-4)
    else:
        assert not r[..., 2].any()


@named
def test_halved_elements_interpolate_sixteen_times_better(name):
    """Fourth order shows that nodal derivatives are those of the surface, the mixed one too."""
    if name == "plate":
        return
    errors = [_distance(name, n) for n in (2, 4)]
    assert 12.0 < errors[0] / errors[1] < 24.0


def _distance(name, n):
    """Largest distance between the corresponding points of the interpolation and the surface."""
    make = {
        "tube": lambda k: tube(0.3, 1.1, 8 * k, 2 * k),
        "panel": lambda k: tube(0.3, 1.1, 3 * k, k, (-0.4, 0.9)),
        "annulus": lambda k: annulus(0.6, 1.0, k, 8 * k),
        "sector": lambda k: annulus(0.6, 1.0, k, 2 * k, QUARTER),
        "sphere": lambda k: sphere(0.8, 8 * k, 4 * k, (-1.2, 1.2)),
        "octant": lambda k: sphere(0.8, 2 * k, 2 * k, (0.1, 1.3), QUARTER),
    }[name]
    middle = interpolated(make(n), np.array([0.25, 0.5]), np.array([0.5, 0.75]))[0]
    exact = make(4 * n)  # its nodes are the points that are asked for
    gap = np.linalg.norm(middle.reshape(-1, 1, 3) - exact.points, axis=2)
    return gap.min(axis=1).max()


@named
def test_derivatives_at_nodes_are_those_of_the_neighbours(name):
    """Central differences of nodal values of a fine grid, inside the surface."""
    s = SURFACES[name]
    for quad, (a, b) in zip(s.quads, s.sizes, strict=True):
        along_u = (s.points[quad[1]] - s.points[quad[0]]) / a
        along_v = (s.points[quad[3]] - s.points[quad[0]]) / b
        mean_u, mean_v = s.d_u[quad[[0, 1]]].mean(axis=0), s.d_v[quad[[0, 3]]].mean(axis=0)
        np.testing.assert_allclose(along_u, mean_u, atol=0.04)
        np.testing.assert_allclose(along_v, mean_v, atol=0.04)
        mixed = (s.d_u[quad[3]] - s.d_u[quad[0]]) / b
        np.testing.assert_allclose(mixed, s.d_uv[quad[[0, 3]]].mean(axis=0), atol=0.04)


def test_closed_directions_share_nodes():
    assert len(SURFACES["tube"].points) == 16 * 4
    assert len(SURFACES["sphere"].points) == 16 * 13
    assert len(SURFACES["panel"].points) == 6 * 4
    assert len(SURFACES["annulus"].points) == 3 * 25


@named
def test_every_node_is_used_and_none_is_double(name):
    s = SURFACES[name]
    assert set(s.quads.ravel()) == set(range(len(s.points)))
    gap = np.linalg.norm(s.points[:, None] - s.points, axis=2) + np.eye(len(s.points))
    edges = 3 if name == "annulus" else 0  # the slit
    assert np.sum(gap < 1e-12) == 2 * edges


def test_numbering():
    s = plate(2.0, 0.6, 2, 3)
    np.testing.assert_allclose(s.points.reshape(3, 4, 3)[1, 2], [1.0, 0.4, 0.0])
    np.testing.assert_array_equal(s.quads[0], [0, 4, 5, 1])


def test_uneven_lines():
    def flat(u, v):
        o = np.zeros_like(u)
        x, y = np.stack([o + 1, o, o], 1), np.stack([o, o + 1, o], 1)
        return np.stack([u, v, o], 1), x, y, np.zeros((u.size, 3))

    s = patch(flat, [0.0, 0.1, 1.0], [0.0, 0.5])
    np.testing.assert_allclose(s.sizes, [[0.1, 0.5], [0.9, 0.5]])
    with pytest.raises(ValueError, match="grid lines of v must rise"):
        patch(flat, [0.0, 1.0], [0.0, 0.5, 0.5])


def test_placed():
    axes = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
    s = placed(SURFACES["sector"], [1.0, 2.0, 3.0], axes)
    np.testing.assert_allclose(np.linalg.norm(s.points - [1, 2, 3], axis=1)[:5], 0.6)
    np.testing.assert_allclose(np.cross(s.d_u, s.d_v)[:5], [[1.0, 0, 0]] * 5 * np.array([0.75]))
    np.testing.assert_allclose(s.d_uv @ axes.T, SURFACES["sector"].d_uv)


@pytest.mark.parametrize("make", [lambda: plate(1, 1, 0, 1), lambda: sphere(1, 4, 4, (0, 1.6))])
def test_what_cannot_be_made(make):
    with pytest.raises(ValueError, match=r"at least one element|latitudes must lie"):
        make()
