"""Motions that nothing holds: unsupported bodies, by name and direction.

Elements have no soft motions but the rigid ones, so these are sought among the rigid motions of
all bodies and the coordinates of joints: a small space that is free of the round-off of stiff
bodies, in which a slender beam could pass for a mechanism.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space
from scipy.sparse import csc_array, hstack

from mechanics.description import FloatingFrame
from mechanics.system import Coefficients, Factors, System

Array = NDArray[np.float64]

HELD = 1e-9
"""Part of a motion that constraints must take away for it to be held [-]."""
STIFF = 1e-12
"""Stiffness of a motion, relative to that of the bodies, below which it is free [-]."""
SHOWN = 3
"""Bodies named in one message."""


def free_motions(system: System, y: Array, coef: Coefficients) -> list[str]:
    """What moves without resistance about ``y`` (n + m,): one text for each body; [] if nothing."""
    system = system.following(y[: system.n])
    data = system.matrix(y, np.zeros_like(y), 0.0, system.timed(coef, 0.0), Factors(0.0, 1.0, 0.0))
    matrix, n = system.pattern.matrix(data), system.n
    motions = rigid_motions(system, y)
    # a column of a straight cable, its turn about itself, may vanish
    length = np.sqrt((motions.multiply(motions)).sum(axis=0))
    scaled = motions @ csc_array(
        np.diag(np.where(length > 0.0, 1.0 / np.maximum(length, 1e-300), 0))
    )
    rows = (matrix[n:, :n] @ scaled).toarray()
    rows /= np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-300)
    rows = np.vstack([rows, np.diag((length == 0.0).astype(float))])
    free = null_space(rows, rcond=HELD)
    soft = (scaled.T @ (matrix[:n, :n] @ scaled)).toarray()
    stiff = (abs(scaled).T @ (abs(matrix[:n, :n]) @ abs(scaled))).toarray()
    values, vectors = np.linalg.eigh(free.T @ soft @ free)
    loose = free @ vectors[:, np.abs(values) <= STIFF * np.max(stiff, initial=0.0)]
    return _texts(system, loose / np.maximum(length, 1e-300)[:, None])


def rigid_motions(system: System, y: Array) -> csc_array:
    """(n, k) rigid motions about ``y``: six of each body, three of a particle, one of a joint.

    Three translations, then three turns about the mean place of the nodes, divided by the size
    of the body.
    """
    blocks = []
    for name, nodes in system.layout.node_dofs.items():
        blocks.append(_of_body(system, y, name, nodes))
    own = list(system.layout.joint_dofs.values())
    ones = csc_array((np.ones(len(own)), (own, range(len(own)))), shape=(system.n, len(own)))
    return csc_array(hstack([*blocks, ones]))


def _of_body(system: System, y: Array, name: str, nodes: NDArray) -> csc_array:
    count = system.layout.kinds[name] // 3
    rows = nodes[:, None] + np.arange(3 * count)
    vectors = y[rows].reshape(len(nodes), count, 3)
    shift = np.zeros((3, *vectors.shape))
    shift[:, :, 0] = np.eye(3)[:, None]
    if count * len(nodes) == 1:
        columns = shift.reshape(3, -1)
    else:
        arms = vectors.copy()
        if isinstance(system.layout.bodies[name], FloatingFrame):
            arms[:, 4:] = 0.0  # amplitudes of modes do not turn
        arms[:, 0] -= arms[:, 0].mean(axis=0)
        turn = np.cross(np.eye(3)[:, None, None], arms) / system.scale[nodes[0]]
        columns = np.concatenate([shift, turn]).reshape(6, -1)
    k = len(columns)
    at = np.tile(rows.ravel(), k), np.repeat(np.arange(k), rows.size)
    return csc_array((columns.ravel(), at), shape=(system.n, k))


def _texts(system: System, loose: Array) -> list[str]:
    """Bodies, then joints, with the directions in which they move."""
    largest = np.max(np.abs(loose), initial=0.0)
    if largest == 0.0:
        return []
    found, at = [], 0
    for name, kind in system.layout.kinds.items():
        k = 3 if kind * len(system.layout.node_dofs[name]) == 3 else 6
        part = loose[at : at + k]
        at += k
        if np.max(np.abs(part)) > 1e-6 * largest:
            found.append(f"body {name!r}: it can " + _motions(part))
    for name, row in zip(system.layout.joint_dofs, loose[at:], strict=True):
        if not found and np.max(np.abs(row)) > 1e-6 * largest:
            found.append(f"coordinate {name!r} of a joint")
    more = [f"{len(found) - SHOWN} more"] if len(found) > SHOWN else []
    return found[:SHOWN] + more


def _motions(part: Array) -> str:
    """Words for the motions (3 or 6, r) of one body."""
    words, r = [], part.shape[1]
    turning = part[3:] if len(part) == 6 else np.zeros((0, r))
    axes, still = _range(turning), np.eye(r)
    if axes.size:
        words.append("turn about " + _directions(axes))
        still = null_space(turning, rcond=1e-6)
    paths = _range(part[:3] @ still)
    if paths.size:
        words.insert(0, "move along " + _directions(paths))
    return " and ".join(words)


def _range(motions: Array) -> Array:
    """(3, r) orthonormal basis of the directions of motions (3, k)."""
    if not motions.size:
        return np.zeros((3, 0))
    u, s, _ = np.linalg.svd(motions)
    return u[:, : np.count_nonzero(s > 1e-6 * max(s[0], 1e-300))] if s[0] > 1e-9 else u[:, :0]


def _directions(basis: Array) -> str:
    """Names of axes where they span the same space, else components."""
    inside = np.linalg.norm(basis, axis=1)
    named = [name for name, part in zip("xyz", inside, strict=True) if part > 1.0 - 1e-6]
    if len(named) == basis.shape[1]:
        return " and ".join(named) if len(named) < 3 else "x, y and z"
    signs = np.sign(basis[np.argmax(np.abs(basis), axis=0), range(basis.shape[1])])
    columns = (basis * signs).T
    return " and ".join("({:.3g}, {:.3g}, {:.3g})".format(*(c.round(6) + 0.0)) for c in columns)
