"""Functions of time as data: every history is a frozen record that can be called.

``history(t)`` is a float in SI units at time t [s]; ``history.bounds(end)`` holds all its values
between 0 and ``end``. What begins at t = 0 with a slope has that slope there already, and is
continued before: a crank that is to turn steadily from the start is not at rest first.
"""

from bisect import bisect_right
from dataclasses import dataclass
from math import pi, sin
from typing import Protocol


class History(Protocol):
    """A number that depends on time."""

    def __call__(self, t: float) -> float:
        """Value at time t [s]."""
        ...

    def bounds(self, end: float) -> tuple[float, float]:
        """Least and greatest value for 0 <= t <= end."""
        ...


@dataclass(frozen=True)
class Constant:
    """The same value at all times."""

    value: float

    def __call__(self, t: float) -> float:
        return self.value

    def bounds(self, end: float) -> tuple[float, float]:
        return self.value, self.value


@dataclass(frozen=True)
class Table:
    """Straight lines between points, the end values outside. ``times`` [s] increase."""

    times: tuple[float, ...]
    values: tuple[float, ...]

    def __call__(self, t: float) -> float:
        if t >= self.times[-1]:
            return self.values[-1]
        if t <= self.times[0] and self.times[0] > 0.0:
            return self.values[0]
        i = max(bisect_right(self.times, t), 1)
        x = (t - self.times[i - 1]) / (self.times[i] - self.times[i - 1])
        return (1.0 - x) * self.values[i - 1] + x * self.values[i]

    def bounds(self, end: float) -> tuple[float, float]:
        within = [v for t, v in zip(self.times, self.values, strict=True) if 0.0 < t < end]
        return _span(self(0.0), self(end), *within)


@dataclass(frozen=True)
class Ramp:
    """``first`` until ``start`` [s], ``last`` after ``end`` [s], a straight line between."""

    start: float
    end: float
    first: float
    last: float

    def __call__(self, t: float) -> float:
        x = min((t - self.start) / (self.end - self.start), 1.0)
        if self.start > 0.0:
            x = max(x, 0.0)
        return (1.0 - x) * self.first + x * self.last

    def bounds(self, end: float) -> tuple[float, float]:
        return _span(self(0.0), self(end))


@dataclass(frozen=True)
class Step:
    """``first`` before the time ``at`` [s], ``last`` from then on."""

    at: float
    first: float
    last: float

    def __call__(self, t: float) -> float:
        return self.first if t < self.at else self.last

    def bounds(self, end: float) -> tuple[float, float]:
        return _span(self(0.0), self(end))


@dataclass(frozen=True)
class Sine:
    """offset + amplitude * sin(2 pi frequency t + phase); frequency [Hz], phase [rad]."""

    amplitude: float
    frequency: float
    phase: float
    offset: float

    def __call__(self, t: float) -> float:
        return self.offset + self.amplitude * sin(2.0 * pi * self.frequency * t + self.phase)

    def bounds(self, end: float) -> tuple[float, float]:
        return _span(self.offset - self.amplitude, self.offset + self.amplitude)


@dataclass(frozen=True)
class SCurve:
    """From 0 to ``total`` at a rate that rises smoothly, stays at ``rate`` and falls smoothly.

    The rate rises by the quintic 10 x^3 - 15 x^4 + 6 x^5 during ``rise`` [s], which has
    continuous first and second derivatives, and falls in the same way at the end: the value is
    three times continuously differentiable. Everything is over at ``start + duration``.
    """

    rate: float
    rise: float
    total: float
    start: float = 0.0

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]: the two half ramps together cost one ``rise``."""
        return self.total / self.rate + self.rise

    def __call__(self, t: float) -> float:
        elapsed = min(max(t - self.start, 0.0), self.duration)
        if elapsed <= 0.5 * self.duration:
            return self._risen(elapsed)
        return self.total - self._risen(self.duration - elapsed)

    def _risen(self, elapsed: float) -> float:
        if elapsed >= self.rise:
            return self.rate * (elapsed - 0.5 * self.rise)
        x = elapsed / self.rise
        return self.rate * self.rise * x**4 * (2.5 - 3.0 * x + x * x)

    def bounds(self, end: float) -> tuple[float, float]:
        return _span(self(0.0), self(end))


def _span(*values: float) -> tuple[float, float]:
    return min(values), max(values)
