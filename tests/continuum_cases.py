"""Solid bodies held and loaded at reference points."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from mechanics import statics
from mechanics.continuum_shapes import nodes
from mechanics.description import (
    Clamp,
    Continuum,
    Description,
    Force,
    ReferencePoint,
    Site,
)
from mechanics.modes import modes
from mechanics.system import System
from meshes.materials import constant_material
from meshes.solids import box, member_mesh
from thermal.solid_elements import shape

COLD = 293.15
ALUMINIUM = constant_material("aluminium", 2700.0, 69e9, 0.33, 23.1e-6, 150.0, 900.0)
POISSONLESS = constant_material("no contraction", 2700.0, 70e9, 0.0, 23e-6, 160.0, 900.0)


def areas(mesh, region):
    """Nodes of a region and the area of each, by 3 x 3 points of Gauss on flat or curved quads."""
    family, members = mesh.regions[region]
    faces, form = mesh.cells[family][members], shape(family, 5)
    tangents = np.einsum("pkr,fki->fpri", form.slopes, mesh.points[faces])
    area = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=-1) * form.weights
    total = np.zeros(len(mesh.points))
    np.add.at(total, faces, area @ form.values)
    found = np.unique(faces)
    return found, total[found]


def point(mesh, region, name, axes=None):
    return ReferencePoint(name, "body", *areas(mesh, region), np.eye(3) if axes is None else axes)


class Held(NamedTuple):
    """A body clamped at one end, with a reference point at the other."""

    system: System
    tip: int

    def temperatures(self, field=lambda x: COLD + 0.0 * x[:, 0]):
        T = np.zeros((len(self.system.layout.x), 3))
        T[:, 0] = field(self.system.layout.x)
        return T

    def rest(self, field=None):
        T = self.temperatures() if field is None else self.temperatures(field)
        return self.system.coefficients(T)

    def equilibrium(self, field=None, **options):
        found = statics.equilibrium(self.system, self.rest(), self.rest(field), **options)
        assert found.why == ""
        return found

    def at_tip(self, q):
        """(3, 3) r, r_y, r_z."""
        return q[self.tip : self.tip + 9].reshape(3, 3)

    def frequencies(self, count, found=None, field=None):
        q = self.system.layout.q0 if found is None else found.q
        lam = np.zeros(self.system.m) if found is None else found.lam
        return modes(self.system, q, lam, self.rest(field), count, 1.0).frequencies


def cantilever(
    mesh, material=ALUMINIUM, element="hexahedron20", load=(0.0, 0.0, 0.0), ends=("x0", "x1"),
    damping_time=0.0,
):  # fmt: skip
    cells = mesh.cells[element.removesuffix("-full")]
    body = Continuum("body", mesh.points, cells, material, COLD, element, damping_time=damping_time)
    places = [point(mesh, end, f"body@{i}") for i, end in enumerate(ends)]
    root = mesh.points[places[0].nodes]
    centre = places[0].weights @ root / places[0].weights.sum()
    joints = [Clamp("wall", Site("body@0"), Site(None, position=centre))]
    loads = [Force("load", Site("body@1"), np.asarray(load), lambda t: t)] if any(load) else []
    system = System(Description([body, *places], joints, loads))
    return Held(system, system.layout.node_dofs["body@1"][0])


def bar(size, counts, family="hexahedron20"):
    """A box along x, its axis on the x axis."""
    made = box(size, counts, 2, family)
    return replace(made, points=made.points - 0.5 * np.array([0.0, size[1], size[2]]))


def straight(length, section, cells, around, layers=1):
    x = np.linspace(0.0, length, cells + 1)
    points = np.column_stack([x, 0.0 * x, 0.0 * x])
    return member_mesh(points, np.tile(np.eye(3), (cells + 1, 1, 1)), section, around, layers, 2)


def free(mesh, material=ALUMINIUM, element="hexahedron20", **options):
    cells = mesh.cells[element.removesuffix("-full")]
    body = Continuum("body", mesh.points, cells, material, COLD, element, **options)
    return Held(System(Description([body])), 0)


def scikit_fem(mesh, order):
    """scikit-fem's basis of vectors on the same cells with straight edges, and our coordinates.

    The second is, for each of its unknowns, the number of ours.
    """
    import skfem

    cells = mesh.cells["hexahedron20"]
    corners, local = np.unique(cells[:, :8], return_inverse=True)
    places, theirs = nodes("hexahedron20")[:8], skfem.MeshHex.init_refdom().p.T
    at = [int(np.linalg.norm(places - place, axis=1).argmin()) for place in theirs]
    made = skfem.MeshHex(mesh.points[corners].T, local.reshape(-1, 8)[:, at].T)
    element = skfem.ElementVector(skfem.ElementHexS2())
    basis = skfem.Basis(made, element, intorder=order)
    node = cKDTree(mesh.points).query(basis.doflocs.T)[1]
    ours = np.empty(basis.N, int)
    for direction in range(3):
        rows = basis.get_dofs(elements=True).all(f"u^{direction + 1}")
        ours[rows] = 3 * node[rows] + direction
    return basis, ours


def distorted(counts=(3, 2, 2), size=(0.3, 0.2, 0.2), amount=0.02, family="hexahedron20"):
    """A box whose inner corners are moved; edges stay straight."""
    made = box(size, counts, 2, family)
    cells, points = made.cells[family], made.points.copy()
    corners = np.unique(cells[:, :8])
    inside = np.all((points > 1e-9) & (points < np.array(size) - 1e-9), axis=1)
    moved = corners[inside[corners]]
    points[moved] += amount * np.random.default_rng(1).uniform(-1, 1, (len(moved), 3))
    middles = nodes(family)
    trilinear = np.prod(
        np.where(middles[:8][None] > 0.5, middles[:, None], 1.0 - middles[:, None]), axis=2
    )
    points[cells] = trilinear @ points[cells[:, :8]]
    return replace(made, points=points)
