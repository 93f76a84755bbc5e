"""Bodies of every kind, one end of a joint on each, and constraints evaluated as arrays."""

import numpy as np

from mechanics import kernels
from mechanics.description import Beam, Particle, RigidBody, Shell, Site
from mechanics.joints import build
from mechanics.layout import Layout
from mechanics.rigid import build as build_rigid
from meshes.surfaces import Surface, tube

X, Y, Z = np.eye(3)
DIAGONAL = np.array([1.0, 2.0, -1.0]) / np.sqrt(6.0)
POINT = np.array([3.0, 2.5, 3.2])
"""Where the ends of ``ENDS`` are."""


def rotation(axis, angle):
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def triad(tangent, normal):
    e1 = tangent / np.linalg.norm(tangent)
    e2 = normal - (normal @ e1) * e1
    e2 /= np.linalg.norm(e2)
    return np.array([e1, e2, np.cross(e1, e2)])


def beam(name, start, end, nodes=2, element="beam3243", **motion):
    start, end = np.array(start, float), np.array(end, float)
    points = np.linspace(start, end, nodes)
    axes = np.tile(triad(end - start, np.array([0.3, 1.0, 0.2])), (nodes, 1, 1))
    return Beam(name, points, axes, None, None, 293.15, element=element, **motion)


def arc(name, radius, angle, nodes, element="beam3243"):
    """A beam bent to a circle about z in its reference."""
    phi = np.linspace(0.0, angle, nodes)
    e1 = np.stack([-np.sin(phi), np.cos(phi), 0 * phi], axis=1)
    e2 = np.stack([-np.cos(phi), -np.sin(phi), 0 * phi], axis=1)
    axes = np.stack([e1, e2, np.tile(Z, (nodes, 1))], axis=1)
    return Beam(name, -radius * e2, axes, None, None, 293.15, element=element)


def rigid(name, position, turn=0.4, **more):
    axes = rotation(DIAGONAL, turn)
    return RigidBody(name, np.asarray(position, float), 2.0, np.diag([1.0, 2.0, 1.5]), axes, **more)


def _shell(name, element):
    surface = tube(0.7, 2.0, 6, 2)
    matrix, node = rotation(DIAGONAL, 0.6), 4
    points = (surface.points - surface.points[node]) @ matrix.T + POINT
    turned = [d @ matrix.T for d in (surface.d_u, surface.d_v, surface.d_uv)]
    moved = Surface(points, surface.quads, surface.sizes, *turned)
    return Shell(name, moved, 0.01, None, 293.15, element=element)


def _reaching(name, end, fraction, element="beam3243"):
    """A beam whose point at ``fraction`` of its second element is at POINT."""
    step = (np.asarray(end, float) - POINT) / (2.0 - fraction)
    start = POINT - (1.0 + fraction) * step
    return beam(name, start, start + 3.0 * step, 4, element)


_ARM = beam("arm", (1, 2, 3), POINT, 3)
_STRUT = beam("strut", POINT, (3.4, 1.0, 4.0))
_OFFSET = np.array([0.0, 0.12, -0.2])
_BESIDE = POINT - _OFFSET @ triad(np.array([1.0, 0.3, 0.0]), np.array([0.3, 1.0, 0.2]))

BODIES = (
    _ARM,
    _STRUT,
    beam("wire", POINT, (1.0, 4.5, 18.2), element="cable"),
    _reaching("spar", (5.0, 2.0, 4.0), 0.3),
    _reaching("rope", (5.0, 2.0, 4.0), 0.7, "cable"),
    beam("pipe", _BESIDE, _BESIDE + np.array([1.0, 0.3, 0.0])),
    _shell("skin", "shell48"),
    _shell("plate", "shell24"),
    Particle("ball", POINT, 2.0),
    rigid("hub", POINT),
    rigid("block", POINT - [0.1, 0.2, 0.3] @ rotation(DIAGONAL, 0.4)),
    beam("quad", POINT - [1.0, 0.0, 0.2], POINT + np.array([1.0, 0.0, 0.2]), 3, "beam3333"),
    _shell("thick", "shell3443"),
)
ENDS = {
    "ground": Site(None, position=POINT),
    "arm": Site("arm", -1),
    "strut": Site("strut"),
    "wire": Site("wire"),
    "spar": Site("spar", 1, fraction=0.3),
    "rope": Site("rope", 1, fraction=0.7),
    "pipe": Site("pipe", 0, offset=_OFFSET),
    "skin": Site("skin", 4),
    "plate": Site("plate", 4),
    "ball": Site("ball"),
    "hub": Site("hub"),
    "block": Site("block", offset=np.array([0.1, 0.2, 0.3])),
    "quad": Site("quad", 1),
    "thick": Site("thick", 4),
}
"""An end on every kind of body: at nodes, between nodes, beside the axis, on surfaces."""


def _used(joints):
    """Those of ``BODIES`` on which joints have ends."""
    held = [value for joint in joints for value in vars(joint).values()]
    sites = [site for value in held for site in (value if isinstance(value, list) else [value])]
    names = {getattr(site, "body", None) for site in sites} | {
        getattr(joint, "body", None) for joint in joints
    }
    return [body for body in BODIES if body.name in names]


class Rows:
    """All constraints of some joints, as functions of the coordinates and multipliers.

    With ``rigid_too`` also those that keep rigid bodies rigid; ``caught``: latches hold.
    """

    caught = False

    def __init__(self, joints, bodies=None, rigid_too=False):
        bodies = tuple(bodies) if bodies else _used(joints)
        self.layout = Layout.of(bodies, joints)
        self.n = self.layout.ndof
        held = [body for body in bodies if isinstance(body, RigidBody)] if rigid_too else []
        self.terms = [build_rigid(held, self.layout, self.n)] if held else []
        self.terms += build(joints, self.layout, self.n + 6 * len(held))
        self.m = sum(term.rows for term in self.terms)

    @property
    def names(self):
        each = [np.repeat(term.names, term.rows // len(term.names)) for term in self.terms]
        return [str(name) for names in each for name in names]

    @property
    def driven(self):
        return np.concatenate([term.driven for term in self.terms])

    def coefficients(self, term, t):
        coef = term.coefficients(np.zeros((0, 3)))
        for row, column, history in getattr(term, "signals", ()):
            coef[row, column] = history(t)
        for latch in getattr(term, "latches", ()):
            coef[latch.row, 1] = float(self.caught)
        return coef

    def force(self, q, lam, t=0.0):
        """(n + m,) λ Φ_q and Φ."""
        y, out = np.concatenate([q, lam]), np.zeros(self.n + self.m)
        for term in self.terms:
            kernels.add_force(term, y, 0 * y, self.coefficients(term, t), out)
        return out

    def values(self, q, t=0.0):
        return self.force(q, np.zeros(self.m), t)[self.n :]

    def tangent(self, q, lam, t=0.0, cK=1.0):
        """(n + m, n + m) assembled; what belongs to absent coordinates must not count."""
        y, size = np.concatenate([q, lam]), self.n + self.m
        full = np.zeros((size, size))
        for term in self.terms:
            blocks = kernels.tangent_blocks(term, y, 0 * y, self.coefficients(term, t), cK, 0.0)
            for dofs, block in zip(term.dofs, blocks, strict=True):
                held = dofs >= 0
                assert not block[~held].any()
                assert not block[:, ~held].any()
                np.add.at(full, (dofs[held][:, None], dofs[held]), block[np.ix_(held, held)])
        return full

    def jacobian(self, q, t=0.0):
        return self.tangent(q, np.zeros(self.m), t)[self.n :, : self.n]

    def follow(self, q, t):
        """The nearest coordinates at which all rows vanish."""
        for _ in range(30):
            values = self.values(q, t)
            if np.abs(values).max() < 1e-13:
                return q
            q = q - np.linalg.lstsq(self.jacobian(q, t), values, rcond=1e-10)[0]
        raise AssertionError(f"rows left at {np.abs(values).max():.3g}")

    def balance(self, q, load, free, t=0.0):
        """Coordinates and multipliers at which ``load`` (n,) is carried, others held."""
        at = np.concatenate([free, self.n + np.arange(self.m)])
        y, load = np.concatenate([q, np.zeros(self.m)]), np.append(load, np.zeros(self.m))
        for _ in range(60):
            rest = (self.force(y[: self.n], y[self.n :], t) - load)[at]
            if np.abs(rest).max() < 1e-12:
                return y[: self.n], y[self.n :]
            y[at] -= np.linalg.lstsq(
                self.tangent(y[: self.n], y[self.n :], t)[np.ix_(at, at)], rest, rcond=1e-12
            )[0]
        raise AssertionError(f"forces left at {np.abs(rest).max():.3g}")

    def moved(self, seed=1, amount=0.2):
        """Coordinates away from the reference, sections strained and sheared."""
        q = self.layout.q0.copy()
        return q + amount * np.random.default_rng(seed).standard_normal(q.size)


def difference(function, x, step=1e-6):
    columns = [
        (function(x + step * e) - function(x - step * e)) / (2 * step) for e in np.eye(x.size)
    ]
    return np.stack(columns, axis=-1)


def check_derivatives(rows, q, times=(0.0, 1.7), tolerance=2e-8):
    """Force, Jacobian and second derivatives against differences of the force."""
    lam = np.random.default_rng(2).standard_normal(rows.m)
    for t in times:
        y = np.concatenate([q, lam])

        def force(y, t=t):
            return rows.force(y[: rows.n], y[rows.n :], t)

        touched = np.unique(np.concatenate([term.dofs.ravel() for term in rows.terms]))
        touched = touched[touched >= 0]
        exact = np.zeros((y.size, y.size))
        for k in touched:
            e = np.zeros(y.size)
            e[k] = 1e-6
            exact[:, k] = (force(y + e) - force(y - e)) / 2e-6
        found = rows.tangent(q, lam, t)
        np.testing.assert_allclose(found, exact, rtol=0, atol=tolerance)
        halved = rows.tangent(q, lam, t, cK=0.5)
        expected = found.copy()
        expected[: rows.n, : rows.n] *= 0.5
        np.testing.assert_allclose(halved, expected, rtol=0, atol=1e-12)
