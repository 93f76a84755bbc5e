"""Planar revolute joints with clearance in space.

The journal centre has coordinates y1, y2 in the bearing's plane and the journal turns by θ. With
ρ = |(y1, y2)|, n = (y1, y2)/ρ, τ = (−n2, n1, R):

    δ = ρ − c,   F = max(0, K δ^p (1 + D δ̇/v)),   v_t = τ·(ẏ1, ẏ2, θ̇),   S = μ v_t/(|v_t| + ε)

and the generalised force on (y1, y2, θ) is −F (n1, n2, 0) − F S τ. Virtual work carries it to the
coordinates of journal and bearing.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from mechanics import contact
from mechanics.description import ClearanceRevolute, Friction
from mechanics.joints import direction, normal_to, origin, unit, unit_direction
from mechanics.layout import CABLE, FIXED, PARTICLE, Layout, Side
from mechanics.relative import DIRECTION, OFFSET, Terms, evaluate

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

COEFFICIENTS = (
    "stiffness", "clearance", "friction", "factor", "radius", "exponent",
    "regularisation_speed", "reference_speed", "core",
)  # fmt: skip
"""Columns of ``Clearance.coefficients``: K, c, μ, D, R, p, ε, a given v (0: none), the core."""

CORE = 1e-6
"""Distance in clearances that the radius keeps at the centre, so that n is smooth there [-]:
ρ² = y1² + y2² + core²."""

COLUMNS = (
    "y1", "y2", "theta", "y1_rate", "y2_rate", "theta_rate", "clearance", "penetration", "rate",
    "elastic_force", "dissipative_force", "friction_force", "slip_speed",
)  # fmt: skip
"""Columns of ``Clearance.response``: position [m] and turn [rad, within ±π] of the journal in the
bearing with their rates, clearance c, penetration δ [m] and its rate [m/s], elastic and
dissipative part of the normal force, friction on the journal along τ [N], slip speed [m/s]."""


@njit(cache=True, error_model="numpy")
def _respond(z, Z, v, dofs, coef, approach, response, parts, Y):
    """Response, forces (n, 3, 3) on (y1, y2, θ): elastic, dissipative, friction; Y = ∂y/∂q."""
    for j in range(dofs.shape[0]):
        r, f, c, s = response[j], parts[j], z[j, 2], z[j, 3]
        size = c**2 + s**2 if c != 0.0 or s != 0.0 else 1.0
        r[0], r[1], r[2] = z[j, 0], z[j, 1], np.arctan2(s, c)
        r[3] = r[4] = r[5] = 0.0
        for i in range(18):
            Y[j, 0, i], Y[j, 1, i] = Z[j, 0, i], Z[j, 1, i]
            Y[j, 2, i] = (c * Z[j, 3, i] - s * Z[j, 2, i]) / size
            if dofs[j, i] >= 0:
                for k in range(3):
                    r[3 + k] += Y[j, k, i] * v[dofs[j, i]]
        K, clearance, mu, D = coef[j, 0], coef[j, 1], coef[j, 2], coef[j, 3]
        R, p, eps = coef[j, 4], coef[j, 5], coef[j, 6]
        speed = coef[j, 7] if coef[j, 7] > 0.0 else approach[j]
        rho = np.sqrt(r[0] ** 2 + r[1] ** 2 + coef[j, 8] ** 2)
        n1, n2 = r[0] / rho, r[1] / rho
        r[6], r[7], r[8] = clearance, rho - clearance, n1 * r[3] + n2 * r[4]
        r[12] = n1 * r[4] - n2 * r[3] + R * r[5]
        elastic = K * r[7] ** p if r[7] > 0.0 else 0.0
        normal = elastic * max(0.0, 1.0 + D * r[8] / speed) if speed > 0.0 else elastic
        r[9], r[10] = elastic, normal - elastic
        r[11] = -mu * normal * r[12] / (abs(r[12]) + eps)
        for k in range(2):
            f[k, 0], f[k, 1], f[k, 2] = -r[9 + k] * n1, -r[9 + k] * n2, 0.0
        f[2, 0], f[2, 1], f[2, 2] = -r[11] * n2, r[11] * n1, r[11] * R


@njit(cache=True, error_model="numpy")
def _law(r, coef, approach, fy, fv):
    """Derivatives (3, 3) of F (n, 0) + F S τ by (y1, y2, θ) and by their rates, in contact."""
    fy[:] = 0.0
    fv[:] = 0.0
    rho, normal, mu, R, p, eps = r[7] + r[6], r[9] + r[10], coef[2], coef[4], coef[5], coef[6]
    speed = coef[7] if coef[7] > 0.0 else approach
    n, tau, m = np.empty(3), np.empty(3), np.empty(3)
    n[0], n[1], n[2] = r[0] / rho, r[1] / rho, 0.0
    tau[0], tau[1], tau[2] = -n[1], n[0], R
    m[0], m[1], m[2] = r[4], -r[3], 0.0
    by_depth, by_rate = p * normal / r[7], r[9] * coef[3] / speed if speed > 0.0 else 0.0
    S = mu * r[12] / (abs(r[12]) + eps)
    steep = mu * normal * eps / (abs(r[12]) + eps) ** 2
    turning = n[0] * m[0] + n[1] * m[1]
    for k in range(3):
        for i in range(2):
            rate = (r[3 + i] - n[i] * r[8]) / rho  # ∂δ̇/∂y
            slip = (m[i] - n[i] * turning) / rho  # ∂v_t/∂y
            fy[k, i] = (n[k] + S * tau[k]) * (by_depth * n[i] + by_rate * rate)
            fy[k, i] += steep * tau[k] * slip
        for i in range(3):
            fv[k, i] = (n[k] + S * tau[k]) * by_rate * n[i] + steep * tau[k] * tau[i]
    for k in range(2):
        for i in range(2):
            turn = ((k == i) - n[k] * n[i]) / rho * normal  # F ∂n/∂y
            fy[k, i] += turn
            fy[1 - k, i] += S * turn * (1.0 if k == 0 else -1.0)


@njit(cache=True, error_model="numpy")
def _bend_angle(c, s, Zc, Zs, Hc, Hs):
    """Overwrite Hc with ∂²θ/∂q² for θ = atan2(s, c)."""
    size = c**2 + s**2 if c != 0.0 or s != 0.0 else 1.0
    a, b = 2.0 * c * s / size**2, (s**2 - c**2) / size**2
    for i in range(18):
        for j in range(18):
            Hc[i, j] = (c * Hs[i, j] - s * Hc[i, j]) / size
            Hc[i, j] += a * (Zc[i] * Zc[j] - Zs[i] * Zs[j]) + b * (Zc[i] * Zs[j] + Zs[i] * Zc[j])


@njit(cache=True, error_model="numpy")
def _tangent(z, Z, H, v, dofs, coef, approach, response, parts, Y, cK, cC, blocks):
    """blocks = cK ∂f/∂q + cC ∂f/∂v of the resisting force f = Yᵀ(F (n, 0) + F S τ)."""
    fy, fv, B, C = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 18)), np.empty((3, 18))
    for e in range(dofs.shape[0]):
        blocks[e] = 0.0
        if response[e, 9] + response[e, 10] <= 0.0:
            continue
        _law(response[e], coef[e], approach[e], fy, fv)
        _bend_angle(z[e, 2], z[e, 3], Z[e, 2], Z[e, 3], H[e, 2], H[e, 3])
        B[:] = 0.0  # ∂ẏ/∂q
        C[:] = 0.0  # cK (∂f_y/∂q) + cC (∂f_y/∂v)
        for k in range(3):
            for j in range(18):
                if dofs[e, j] >= 0:
                    for i in range(18):
                        B[k, i] += H[e, k, i, j] * v[dofs[e, j]]
        for k in range(3):
            for m in range(3):
                for i in range(18):
                    C[k, i] += (cK * fy[k, m] + cC * fv[k, m]) * Y[e, m, i] + cK * fv[k, m] * B[
                        m, i
                    ]
        for k in range(3):
            f = -cK * (parts[e, 0, k] + parts[e, 1, k] + parts[e, 2, k])
            for i in range(18):
                for j in range(18):
                    blocks[e, i, j] += Y[e, k, i] * C[k, j] + f * H[e, k, i, j]


@dataclass(frozen=True, eq=False)
class Clearance:
    """All clearance joints of a system as one term.

    Attributes
    ----------
    names : joints
    dofs : (n_j, 18) int  coordinates of journal and bearing; -1 where absent
    points : (n_j, 2) int  rows of journal and bearing in the temperature array
    planes : (n_j, 2, 3) float  directions of y1 and y2 in the reference
    factors : (n_j,) float  D of the dissipation law and restitution of each joint
    columns : names of the columns of ``response``
    """

    names: tuple[str, ...]
    dofs: Indices
    points: Indices
    planes: Array
    joints: tuple[ClearanceRevolute, ...]
    factors: Array
    terms: Terms
    columns: tuple[str, ...] = COLUMNS

    def coefficients(self, T: Array) -> Array:
        """(n_j, 9) float, columns ``COEFFICIENTS``, for section temperatures ``T`` (m, 3)."""
        each = zip(self.joints, self.factors, T[self.points, 0], strict=True)
        return np.array([_coefficients(joint, D, *at) for joint, D, at in each])

    def partition(self, T: Array) -> Array:
        """(n_j, 2) float [-]  share of the frictional heat of journal and bearing."""
        at = T[self.points, 0]
        weights = [_heat_weights(j, *t) for j, t in zip(self.joints, at, strict=True)]
        return np.array(weights) / np.sum(weights, axis=1, keepdims=True)

    def force(self, q: Array, v: Array, coef: Array, approach: Array, out: Array) -> None:
        """out += resisting force; ``approach`` (n_j,) [m/s], not positive: no dissipation."""
        _, parts, gradients = self._respond(q, v, coef, approach)
        local = -np.einsum("jk,jki->ji", parts.sum(axis=1), gradients)
        present = self.dofs >= 0
        np.add.at(out, self.dofs[present], local[present])

    def tangent(
        self, q: Array, v: Array, coef: Array, approach: Array, cK: float, cC: float, blocks: Array
    ) -> None:
        """Overwrite ``blocks`` (n_j, 18, 18) with cK ∂f/∂q + cC ∂f/∂v.

        Entries of absent coordinates mean nothing and are to be dropped.
        """
        z, Z = self._evaluate(q)
        kept = self._contact(z, Z, v, coef, approach)
        H = self._bends(q, touching=kept[0][:, 9] > 0.0)
        _tangent(z, Z, H, v, self.dofs, coef, approach, *kept, cK, cC, blocks)

    def energy(self, q: Array, coef: Array) -> float:
        """Elastic energy K δ^(p+1)/(p+1) of all contacts [J]."""
        still = np.zeros(len(self.dofs))
        depth = np.maximum(self.response(q, np.zeros_like(q), coef, still)[:, 7], 0.0)
        return float(np.sum(coef[:, 0] * depth ** (coef[:, 5] + 1.0) / (coef[:, 5] + 1.0)))

    def response(self, q: Array, v: Array, coef: Array, approach: Array) -> Array:
        """(n_j, 13) float, columns ``COLUMNS``."""
        return self._respond(q, v, coef, approach)[0]

    def split(self, q: Array, v: Array, coef: Array, approach: Array) -> Array:
        """(n_j, 2, 3) float [N, N, N m]  dissipative normal force and friction on (y1, y2, θ)."""
        return self.losses(q, v, coef, approach)[1]

    def losses(self, q: Array, v: Array, coef: Array, approach: Array) -> tuple[Array, Array]:
        """``response`` and ``split`` of one evaluation."""
        response, parts, _ = self._respond(q, v, coef, approach)
        return response, parts[:, 1:]

    def gradients(self, q: Array) -> Array:
        """(n_j, 3, 18) float  derivatives of (y1, y2, θ) by the coordinates ``dofs``."""
        n = len(self.dofs)
        still = np.zeros_like(q), np.ones((n, len(COEFFICIENTS))), np.zeros(n)
        return self._respond(q, *still)[2]

    def regimes(self, response: Array, coef: Array, approach: Array) -> NDArray[np.int8]:
        """(n_j,) int8  0 free flight, 1 impact, 2 slip, 3 stick; see ``contact.classify``."""
        return contact.classify(
            response[:, 7], response[:, 8], approach, response[:, 12], coef[:, 6]
        )

    def impact_duration(self, coef: Array, mass: Array, speed: Array) -> Array:
        """(n_j,) float [s]  duration of an elastic impact of ``mass`` [kg] at ``speed`` [m/s]."""
        return np.asarray(contact.elastic_impact(mass, coef[:, 0], speed, coef[:, 5]).duration)

    def _respond(
        self, q: Array, v: Array, coef: Array, approach: Array
    ) -> tuple[Array, Array, Array]:
        return self._contact(*self._evaluate(q), v, coef, approach)

    def _evaluate(self, q: Array) -> tuple[Array, Array]:
        n = len(self.dofs)
        z, Z = np.zeros(4 * n), np.zeros((4 * n, 18))
        evaluate(*self.terms, q, z, Z, np.empty((0, 18, 18)))
        return z.reshape(n, 4), Z.reshape(n, 4, 18)

    def _bends(self, q: Array, touching: NDArray[np.bool_]) -> Array:
        """(n_j, 4, 18, 18) second derivatives of the four terms of the joints in contact."""
        n = 4 * len(self.dofs)
        bends = np.zeros((n, 18, 18))
        some = np.repeat(touching, 4)
        if some.any():
            terms = Terms._make(array[some] for array in self.terms)
            evaluate(*terms, q, np.zeros(n), np.zeros((n, 18)), bends)
        return bends.reshape(-1, 4, 18, 18)

    def _contact(
        self, z: Array, Z: Array, v: Array, coef: Array, approach: Array
    ) -> tuple[Array, Array, Array]:
        n = len(self.dofs)
        response, parts, Y = np.empty((n, len(COLUMNS))), np.empty((n, 3, 3)), np.empty((n, 3, 18))
        _respond(z, Z, v, self.dofs, coef, approach, response, parts, Y)
        return response, parts, Y


def build(joints: Sequence[ClearanceRevolute], layout: Layout) -> Clearance:
    """One term for all clearance joints; one that cannot be made is a ``ValueError``."""
    sides = [(layout.site(joint.journal), layout.site(joint.bearing)) for joint in joints]
    for joint in joints:
        _check(joint)
    planes = np.array([_plane(joint, *ab) for joint, ab in zip(joints, sides, strict=True)])
    products = [p for ab, plane in zip(sides, planes, strict=True) for p in _products(*ab, plane)]
    dofs = np.array([np.concatenate([a.dofs, b.dofs]) for a, b in sides], dtype=np.intp)
    count = len(products)
    terms = Terms(
        kind=np.tile(np.array([OFFSET, OFFSET, DIRECTION, DIRECTION], np.intp), len(joints)),
        row=np.arange(count, dtype=np.intp),
        weight=np.ones(count),
        dofs=np.repeat(dofs, 4, axis=0),
        origin=np.repeat([origin(a, b) for a, b in sides], 4, axis=0),
        u=np.array([u for u, _ in products]),
        w=np.array([w for _, w in products]),
    )
    parts = [[f"{joint.name}.{part}" for part in ("journal", "bearing")] for joint in joints]
    points = np.array([[layout.point_index[p][0] for p in pair] for pair in parts], dtype=np.intp)
    laws = [joint.contact for joint in joints]
    factors = np.array([contact.DISSIPATION[w.dissipation](w.restitution) for w in laws])
    names = tuple(j.name for j in joints)
    return Clearance(names, dofs, points, planes, tuple(joints), factors, terms)


def _check(joint: ClearanceRevolute) -> None:
    law = joint.contact
    known = law.stiffness in contact.EXPONENT and law.dissipation in contact.DISSIPATION
    if not known:
        raise ValueError(f"joint {joint.name!r}: unknown law {law.stiffness}, {law.dissipation}")
    if law.stiffness == "linear" and law.value is None:
        raise ValueError(f"joint {joint.name!r}: a linear contact needs its stiffness")


def _plane(joint: ClearanceRevolute, a: Side, b: Side) -> Array:
    """(2, 3) unit vectors along which y1 and y2 are measured in the reference."""
    axis = unit(joint.axis)
    if a.kind == CABLE:
        first = unit(a.triad[0] - (a.triad[0] @ axis) * axis)
    else:
        first = normal_to(axis, b.triad if a.kind in (PARTICLE, FIXED) else a.triad)
    return np.array([first, np.cross(axis, first)])


def _products(a: Side, b: Side, plane: Array) -> list[tuple[Array, Array]]:
    """(u, w) of y1, y2 and of cosine and sine of the turn."""
    turning = np.zeros(7) if a.kind == PARTICLE else direction(a, plane[0])
    sides = [unit_direction(b, e) for e in plane]
    return [(np.zeros(7), w) for w in sides] + [(turning, w) for w in sides]


def _coefficients(joint: ClearanceRevolute, factor: float, Tj: float, Tb: float) -> Array:
    """(9,) coefficients at journal and bearing temperature [K]."""
    law, reference = joint.contact, joint.reference_temperature
    strain = joint.journal_material.thermal_strain(Tj, reference)
    bore = joint.bearing_material.thermal_strain(Tb, reference)
    mu, eps = _friction(joint.friction, 0.5 * (Tj + Tb))
    return np.array([
        _stiffness(joint, Tj, Tb) if law.value is None else law.value,
        contact.thermal_clearance(joint.clearance, joint.radius, strain, bore),
        mu,
        factor,
        joint.radius * (1.0 + strain),
        contact.EXPONENT[law.stiffness],
        eps,
        law.reference_speed or 0.0,
        CORE * joint.clearance,
    ])  # fmt: skip


def _stiffness(joint: ClearanceRevolute, Tj: float, Tb: float) -> contact.Value:
    """Hertz stiffness [N/m^1.5] of the reference radii at both temperatures [K]."""
    radii = joint.radius, joint.radius + joint.clearance
    sides = (joint.journal_material, Tj), (joint.bearing_material, Tb)
    elastic = [f(T) for m, T in sides for f in (m.youngs_modulus, m.poissons_ratio)]
    return contact.hertz_stiffness(contact.hertz_radius(joint.contact.stiffness, *radii), *elastic)


def _friction(friction: Friction | None, T: float) -> tuple[float, float]:
    """Coefficient and regularisation speed [m/s] at the mean temperature."""
    if friction is None:
        return 0.0, 1.0
    mu = contact.friction_coefficient(
        T, friction.coefficient, friction.temperature_slope, friction.reference_temperature
    )
    return float(mu), friction.regularisation_speed


def _heat_weights(joint: ClearanceRevolute, Tj: float, Tb: float) -> tuple[float, float]:
    weight = contact.PARTITION[joint.friction.partition if joint.friction else "effusivity"]
    pairs = ((joint.journal_material, Tj), (joint.bearing_material, Tb))
    return tuple(weight(m.conductivity(T), m.density, m.heat_capacity(T)) for m, T in pairs)
