"""Measures of ``mechanics.clearance_kernels`` and forces from theirs, for several joints at once.

What ``mechanics.relative.evaluate`` does for one product a·w after the other, done for the nine of
a joint together: the three directions of the bearing and both of the journal are made once. See
``mechanics.lanes``.
"""

from typing import Any, NamedTuple

from mechanics.lanes import Lanes, compiled

PRESENT, LOCAL, CONSTANTS, MORE = 0, 2, 20, 58
"""First rows of what goes in: 1 where the journal has each of its two directions, otherwise 0;
local coordinates (18); origin, directions of journal and bearing (38); then local velocities (18)
for the measures and their rates, or the forces (9) that belong to the measures."""
JOURNAL, BEARING = CONSTANTS + 3, CONSTANTS + 17
ABSENT = (0.0, 0.0, 1.0, 1.0, 0.0, 0.0)
"""Components of directions that the journal lacks: those of the bearing."""
LEAST = 1e-300
"""Added to the square of the normal of an end, which is zero where that has no vectors."""
Vector = list[Any]
"""Components: numbers of several joints, or one for all."""


def _dot(a: Vector, b: Vector) -> Lanes:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return [a[j] * b[k] - a[k] * b[j] for j, k in ((1, 2), (2, 0), (0, 1))]


def _sum(*terms: Vector) -> Vector:
    found = terms[0]
    for term in terms[1:]:
        found = [a + b for a, b in zip(found, term, strict=True)]
    return found


def _times(f: Lanes | float, a: Vector) -> Vector:
    return [f * one for one in a]


class End(NamedTuple):
    """p, s of an end, their normal g = p × s, g/√|g|, and |g|²."""

    p: Vector
    s: Vector
    g: Vector
    normal: Vector
    square: Lanes


def _end(x: Vector) -> End:
    p, s = x[3:6], x[6:9]
    g = _cross(p, s)
    square = _dot(g, g) + LEAST
    return End(p, s, g, _times(1.0 / square.root().root(), g), square)


def _normal_rate(end: End, u: Vector) -> Vector:
    """Rate of g/√|g| for velocities of the end."""
    rate = _sum(_cross(u[3:6], end.s), _cross(end.p, u[6:9]))
    along = -0.5 * _dot(end.g, rate) / end.square
    return _sum(_times(1.0 / end.square.root().root(), rate), _times(along, end.normal))


def _direction(end: End, c: Vector) -> Vector:
    varying = _sum(_times(c[0], end.normal), _times(c[1], end.p), _times(c[2], end.s))
    return _sum(c[3:6], varying)


def _direction_rate(normal: Vector, u: Vector, c: Vector) -> Vector:
    return _sum(_times(c[0], normal), _times(c[1], u[3:6]), _times(c[2], u[6:9]))


def _length(W: Vector, unit: Lanes) -> Lanes:
    """By which a direction is divided; ``unit`` (0 or 1) says whether it is."""
    return _dot(W, W).root() * unit + (1.0 - unit)


def _constants(given: Vector) -> tuple[list[Vector], list[Vector]]:
    """c1, c2, c3, constant and whether to divide, of the directions of journal and of bearing."""
    return (
        [given[at : at + 7] for at in range(JOURNAL, BEARING, 7)],
        [given[at : at + 7] for at in range(BEARING, MORE, 7)],
    )


def _offset(given: Vector) -> Vector:
    x = given[LOCAL:CONSTANTS]
    return [x[i] - x[9 + i] + given[CONSTANTS + i] for i in range(3)]


def _measured(given: Vector) -> Vector:
    x, u = given[LOCAL:CONSTANTS], given[MORE:]
    ends, speeds = [_end(x[:9]), _end(x[9:])], [u[:9], u[9:]]
    turning = [_normal_rate(end, fast) for end, fast in zip(ends, speeds, strict=True)]
    own, others = _constants(given)
    first = [_offset(given), *(_direction(ends[0], c) for c in own)]
    rates = [[u[i] - u[9 + i] for i in range(3)]]
    rates += [_direction_rate(turning[0], speeds[0], c) for c in own]
    z: list = [None] * 9
    w: list = [None] * 9
    for i, c in enumerate(others):
        W, fast = _direction(ends[1], c), _direction_rate(turning[1], speeds[1], c)
        size = 1.0 / _length(W, c[6])
        one, fast = _times(size, W), _times(size, fast)
        fast = _sum(fast, _times(-_dot(one, fast) * c[6], one))
        for k in range(3):
            z[3 * k + i] = _dot(first[k], one)
            w[3 * k + i] = _dot(rates[k], one) + _dot(first[k], fast)
    for k in range(3, 9):
        there = given[PRESENT + k // 3 - 1]
        z[k] = z[k] * there + (1.0 - there) * ABSENT[k - 3]
        w[k] = w[k] * there
    return [*z, *w]


def _pulled(end: End, parts: list[tuple[Vector, Vector]]) -> list[Vector]:
    """Gradients by p and s of the sum of P·u over directions u with constants c; see
    ``mechanics.relative``."""
    by_p, by_s, P = ([0.0] * 3 for _ in range(3))
    for c, part in parts:
        by_p, by_s = _sum(by_p, _times(c[1], part)), _sum(by_s, _times(c[2], part))
        P = _sum(P, _times(c[0], part))
    along = -0.5 * _dot(P, end.g) / end.square
    P = _times(1.0 / end.square.root().root(), _sum(P, _times(along, end.g)))
    return [_sum(by_p, _cross(end.s, P)), _sum(by_s, _cross(P, end.p))]


def _gathered(given: Vector) -> Vector:
    x, phi = given[LOCAL:CONSTANTS], given[MORE:]
    ends = [_end(x[:9]), _end(x[9:])]
    own, others = _constants(given)
    phi = [f if k < 3 else f * given[PRESENT + k // 3 - 1] for k, f in enumerate(phi)]
    first = [_offset(given), *(_direction(ends[0], c) for c in own)]
    forces: list = [[0.0] * 3 for _ in range(3)]
    pulls = []
    for i, c in enumerate(others):
        W = _direction(ends[1], c)
        size = 1.0 / _length(W, c[6])
        one = _times(size, W)
        pull = _sum(*(_times(phi[3 * k + i], first[k]) for k in range(3)))
        pull = _times(size, _sum(pull, _times(-_dot(pull, one) * c[6], one)))
        pulls.append((c, pull))
        forces = [_sum(f, _times(phi[3 * k + i], one)) for k, f in enumerate(forces)]
    journal = _pulled(ends[0], list(zip(own, forces[1:], strict=True)))
    bearing = _pulled(ends[1], pulls)
    against = [*forces[0], *journal[0], *journal[1]]
    return [*_times(-1.0, against), *forces[0], *_times(-1.0, [*bearing[0], *bearing[1]])]


measured = compiled(_measured, MORE + 18)
gathered = compiled(_gathered, MORE + 9)
