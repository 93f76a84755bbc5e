"""Small motions of a hinged frame, exact along its members: a reference for meshes.

A member is a straight Timoshenko beam. Its dynamic stiffness at a circular frequency w follows from
the exponential of the matrix of the equations

    w' = phi + Q/(k G A),  phi' = M/(E I),  Q' = -rho A w^2 w,  M' = -Q - rho I w^2 phi

and of the like for stretching and twisting, so that no shape is assumed. It is not linear in w^2:
a frequency is found by Newton's method on the pencil of the stiffness and its slope. As many lie
below w as the dynamic stiffness has negative eigenvalues (Wittrick & Williams 1971), as long as w
is below the lowest frequency of every member with both ends clamped. Shares nothing with the
elements of ``mechanics`` but the numbers of the section.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, eigvalsh, expm, null_space, qr, solve
from scipy.sparse import block_diag, csr_array

from meshes.sections import Section
from meshes.truss import START, Truss

Array = NDArray[np.float64]

CLAMPED = 22.37329
"""w L^2 sqrt(rho A/(E I)) of the first bending of a bar with both ends clamped [-]."""
SAFE = 0.95
"""Part of the clamped frequency up to which frequencies are counted [-]."""
STEP = 1e-30
"""Imaginary step by which the stiffness is derived, in squares of frequencies."""


@dataclass(frozen=True)
class Stuff:
    """Linear elastic material with constants: E, G [Pa], density [kg/m^3], expansion [1/K]."""

    E: float
    G: float
    density: float
    expansion: float


@dataclass(frozen=True, eq=False)
class Frame:
    """A frame in small motions.

    Attributes
    ----------
    names : of the members
    lengths : (n,) float [m];  axes : (n, 3, 3) float  rows e1 (along), e2, e3
    free : (12 n, f) float  motions of the ends that joints and support leave
    rows : (m, 12 n) float  equations of joints and support, orthonormal within a joint
    joints : name of the joint of each row
    """

    names: list[str]
    lengths: Array
    axes: Array
    free: Array
    rows: Array
    joints: list[str]
    section: Section
    stuff: Stuff

    def stiffness(self, square: float | complex) -> csr_array:
        """(12 n, 12 n)  dynamic stiffness of the members at w^2 [rad^2/s^2], in global axes."""
        known: dict[float, Array] = {}
        blocks = []
        for length, axes in zip(self.lengths, self.axes, strict=True):
            key = round(float(length), 12)
            if key not in known:
                known[key] = member_stiffness(square, float(length), self.section, self.stuff)
            turn = np.kron(np.eye(4), axes)
            blocks.append(turn.T @ known[key] @ turn)
        return csr_array(block_diag(blocks))

    def reduced(self, square: float | complex) -> Array:
        """(f, f)  dynamic stiffness of what is free."""
        return self.free.T @ (self.stiffness(square) @ self.free)

    def below(self, w: float) -> int:
        """How many vibrations are slower than w [rad/s].

        Raises
        ------
        ValueError : w is too near the frequencies of single members
        """
        s, m = self.section, self.stuff
        wave = sqrt(m.E * s.second_moment_2 / (m.density * s.area))
        if w > SAFE * CLAMPED * wave / self.lengths.max() ** 2:
            raise ValueError(f"{w:g} rad/s is too near the frequencies of single members")
        return int(np.count_nonzero(eigvalsh(self.reduced(w**2)) < 0.0))

    def frequencies(self, which: Sequence[int]) -> Array:
        """(k,) float [Hz]  of the vibrations with these numbers, 1 being the slowest.

        Raises
        ------
        ValueError : one is too near the frequencies of single members, or was not found
        """
        found = np.array([self._square(number) for number in which])
        w = np.sqrt(found)
        if any(self.below(r * (1.0 + 1e-7)) < number for r, number in zip(w, which, strict=True)):
            raise ValueError("a vibration was missed")
        return w / (2.0 * pi)

    def _square(self, number: int) -> float:
        """w^2 of a vibration [rad^2/s^2], up to where round-off ends Newton's method."""
        square, before = 0.0, np.inf
        while True:
            slope = -np.imag(self.reduced(square + 1j * STEP)) / STEP
            missing = eigh(self.reduced(square), slope, eigvals_only=True,
                           subset_by_index=(number - 1, number - 1))[0]  # fmt: skip
            if abs(missing) > 0.5 * before:
                return float(square)
            square, before = square + missing, abs(missing)

    def heated(self, rises: Array) -> tuple[Array, dict[str, float]]:
        """Equilibrium with members warmer than free of stress.

        Parameters
        ----------
        rises : (n,) float [K]  of the members

        Returns
        -------
        (n, 2, 6) float [m], [rad]  displacements and turns of their ends
        joint name -> force [N] that it transmits
        """
        pull = self.stuff.E * self.section.area * self.stuff.expansion * rises
        ends = np.zeros((len(rises), 12))
        ends[:, 0:3] = -pull[:, None] * self.axes[:, 0]
        ends[:, 6:9] = pull[:, None] * self.axes[:, 0]
        K, f = self.stiffness(0.0), ends.ravel()
        u = self.free @ solve(self.reduced(0.0), self.free.T @ f, assume_a="sym")
        held = np.linalg.lstsq(self.rows.T, f - K @ u, rcond=None)[0]
        forces: dict[str, float] = {}
        for name in dict.fromkeys(self.joints):
            at = [i for i, joint in enumerate(self.joints) if joint == name][:3]
            forces[name] = float(np.linalg.norm(held[at]))
        return u.reshape(-1, 2, 6), forces


def frame(truss: Truss, section: Section, stuff: Stuff) -> Frame:
    """A ring truss, held at the foot of its first post; its members are one beam each."""
    names = [m.name for m in truss.members]
    spans = [m.points[-1] - m.points[0] for m in truss.members]
    lengths = np.array([np.linalg.norm(span) for span in spans])
    axes = np.array([
        _axes(span / length, m.normal)
        for span, length, m in zip(spans, lengths, truss.members, strict=True)
    ])  # fmt: skip
    at = {(name, end): 12 * i + 6 * k for i, name in enumerate(names)
          for k, end in enumerate((START, "end"))}  # fmt: skip
    rows, joints = [], []
    for hinge in truss.hinges:
        a, b = at[hinge.a, hinge.at], at[hinge.base, hinge.base_at]
        for row in _equations(12 * len(names), a, b, hinge.axis):
            rows.append(row)
            joints.append(hinge.name)
    foot = at[truss.corners[0]]
    held = np.zeros((6, 12 * len(names)))
    held[np.arange(6), foot + np.arange(6)] = 1.0
    whole = np.vstack([*rows, held])
    return Frame(names, lengths, axes, _left_by(whole), whole, [*joints, *["support"] * 6],
                 section, stuff)  # fmt: skip


def _left_by(rows: Array) -> Array:
    """(n, f)  orthonormal motions that independent equations leave."""
    return qr(rows.T)[0][:, len(rows) :]


def _axes(along: Array, normal: Array) -> Array:
    across = normal - (normal @ along) * along
    across /= np.linalg.norm(across)
    return np.array([along, across, np.cross(along, across)])


def _equations(n: int, a: int, b: int, axis: Array | None) -> Array:
    """Rows of a spherical hinge, or of a revolute about an axis."""
    rows = np.zeros((3 if axis is None else 5, n))
    rows[[0, 1, 2], [a, a + 1, a + 2]] = 1.0
    rows[[0, 1, 2], [b, b + 1, b + 2]] = -1.0
    if axis is not None:
        across = null_space(axis[None, :] / np.linalg.norm(axis)).T
        rows[3:, a + 3 : a + 6] = across
        rows[3:, b + 3 : b + 6] = -across
    return rows


def member_stiffness(
    square: float | complex, length: float, section: Section, stuff: Stuff
) -> Array:
    """(12, 12)  forces and moments on the ends over their motion at w^2, in the axes of the member.

    Motion of an end: displacements along e1, e2, e3, then turns about them.
    """
    A, m = section.area, stuff.density
    K = np.zeros((12, 12), complex if isinstance(square, complex) else float)
    _put(K, [0, 6], _rod(square, length, stuff.E * A, m * A))
    _put(
        K,
        [3, 9],
        _rod(square, length, stuff.G * section.torsion_constant, m * section.polar_moment),
    )
    for signs, at, second, factor in (
        ((1.0, 1.0), (1, 5, 7, 11), section.second_moment_2, section.shear_factor_2),
        ((1.0, -1.0), (2, 4, 8, 10), section.second_moment_3, section.shear_factor_3),
    ):
        turned = np.diag([*signs, *signs])
        bending = _beam(
            square, length, stuff.E * second, factor * stuff.G * A, m * A, m * second
        )  # fmt: skip
        _put(K, at, turned @ bending @ turned)
    return 0.5 * (K + K.T)


def _put(K: Array, at, part: Array) -> None:
    K[np.ix_(at, at)] = part


def _rod(square: float | complex, length: float, stiff: float, mass: float) -> Array:
    """(2, 2)  end forces over end displacements of a bar that stretches or twists."""
    T = expm(length * np.array([[0.0, 1.0 / stiff], [-square * mass, 0.0]]))
    return _from_transfer(T, 1)


def _beam(
    square: float | complex, length: float, EI: float, kGA: float, mass: float, rotary: float
) -> Array:
    """(4, 4)  forces Q, M over displacement and turn of both ends of a beam that bends."""
    rates = np.array([
        [0.0, 1.0, 1.0 / kGA, 0.0],
        [0.0, 0.0, 0.0, 1.0 / EI],
        [-square * mass, 0.0, 0.0, 0.0],
        [0.0, -square * rotary, -1.0, 0.0],
    ])  # fmt: skip
    return _from_transfer(expm(length * rates), 2)


def _from_transfer(T: Array, k: int) -> Array:
    """Stiffness from what carries displacements and forces from one end to the other."""
    a, b, c, d = T[:k, :k], T[:k, k:], T[k:, :k], T[k:, k:]
    forces = solve(b, np.hstack([-a, np.eye(k)]))  # at the start, over both displacements
    far = np.hstack([c, np.zeros((k, k))]) + d @ forces
    return np.vstack([-forces, far])
