"""A rigid pin in an elastic hole by Michell's series, and the closed form for similar materials.

Plane strain. Airy's functions r^n, r^(n+2), r^-n, r^(-n+2) times cos(n θ) with their stresses and
displacements (Michell 1899; Barber 2010, tables 8.1 and 9.1); the hole is free of shear, its
surroundings are held at ``outer``, or are endless. Where pin and hole touch follows from
complementarity. The first harmonic moves the pin and changes no pressure at a given load.
"""

import numpy as np


def compliance(n, inner, outer, E, nu):
    """Radial displacement [m] of the hole by a pressure cos(n θ) [N/m^2]."""
    mu, kappa = 0.5 * E / (1.0 + nu), 3.0 - 4.0 * nu
    if n == 0:
        return _breathing(inner, outer, mu, kappa)
    here = _rows(n, inner, inner, outer, kappa)
    if np.isinf(outer):
        c = np.append([0.0, 0.0], np.linalg.solve(here[:2, 2:], [-1.0, 0.0]))
    else:
        there = _rows(n, outer, inner, outer, kappa)
        c = np.linalg.solve(np.vstack([here[:2], there[2:]]), [-1.0, 0.0, 0.0, 0.0])
    return float(here[2] @ c) / (2.0 * mu)


def _breathing(inner, outer, mu, kappa):
    if np.isinf(outer):
        return inner / (2.0 * mu)
    rows = np.array([[1.0 / inner**2, 2.0], [-1.0 / outer, (kappa - 1.0) * outer]])
    a, b = np.linalg.solve(rows, [-1.0, 0.0])
    return (-a / inner + (kappa - 1.0) * b * inner) / (2.0 * mu)


def _rows(n, r, inner, outer, kappa):
    """(4, 4) σ_r, τ, 2μ u_r, 2μ u_θ at r of the four functions, two growing and two decaying."""
    x, y = r / outer, inner / r
    rows = np.zeros((4, 4))
    if not np.isinf(outer):
        rows[:, 0] = np.array([1 - n, n - 1, -r, r]) * n * x ** (n - 2)
        rows[:2, 1] = np.array([-(n + 1) * (n - 2), n * (n + 1)]) * x**n
        rows[2:, 1] = np.array([kappa - n - 1, kappa + n + 1]) * x**n * r
    rows[:, 2] = np.array([-n - 1, -n - 1, r, r]) * n * y ** (n + 2)
    rows[:2, 3] = np.array([-(n + 2) * (n - 1), -n * (n - 1)]) * y**n
    rows[2:, 3] = np.array([kappa + n - 1, n - 1 - kappa]) * y**n * r
    return rows


def pressed(load, inner, clearance, E, nu, outer=np.inf, stiffness=np.inf, count=720):
    """Angles (count,), pressure there [N/m^2] and half angle of contact under a load [N/m].

    stiffness : [N/m^3] of a foundation between pin and hole
    """
    angles, n = (np.arange(count) + 0.5) * np.pi / count, np.arange(count)
    give = [0.0 if k == 1 else compliance(k, inner, outer, E, nu) for k in n]
    cosines = np.cos(np.outer(angles, n))
    part = np.where(n == 0, 1.0, 2.0) / count
    G = (cosines * (give * part)) @ cosines.T + np.eye(count) / stiffness
    weights = 2.0 * inner * np.cos(angles) * np.pi / count
    touching = angles < 0.5
    while True:
        m = int(touching.sum())
        A = np.zeros((m + 1, m + 1))
        A[:m, :m] = G[np.ix_(touching, touching)]
        A[:m, m], A[m, :m] = -np.cos(angles[touching]), weights[touching]
        found, p = np.linalg.solve(A, np.append(np.full(m, -clearance), load)), np.zeros(count)
        p[touching] = found[:m]
        open_ = clearance + G @ p - found[m] * np.cos(angles)
        now = np.where(touching, p > 0.0, open_ < 0.0)
        if np.array_equal(now, touching):
            return angles, p, float(angles[touching].max()) + 0.5 * np.pi / count
        touching = now


def similar(b, rigid):
    """Load over E* clearance, b = tan of a quarter of the angle of contact (Persson 1964).

    Ciavarella and Decuzzi 2001 for materials with Dundurs' β = 0: identical ones (α = 0), or a
    rigid pin in an incompressible plane (α = -1); E* = E/(1 - ν²) of the plane.
    """
    shape = np.log(b**2 + 1.0) + 2.0 * b**4
    return np.pi * b**2 * (b**2 + 1.0) / ((1.0 if rigid else 2.0) - shape)
