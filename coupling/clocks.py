"""What the frames and probes of a run go over: time, the load factor, or modes of vibration."""

from collections.abc import Sequence
from typing import NamedTuple

from coupling.reading import Results


class Clock(NamedTuple):
    """Name and unit of what stands in the columns ``time``."""

    name: str
    unit: str

    @property
    def label(self) -> str:
        """Title of an axis or a column."""
        return f"{self.name} [{self.unit}]"


CLOCKS = {
    "dynamics": Clock("time", "s"),
    "statics": Clock("load factor", "-"),
    "modes": Clock("mode", "-"),
}
"""By kind of analysis."""


def analysis_of(results: Results) -> str:
    """Kind of the analysis that made the results."""
    return str(results.attributes().get("analysis", "dynamics"))


def clock_of(results: Results) -> Clock:
    """Clock of the results."""
    return CLOCKS[analysis_of(results)]


def named(results: Results, frames: Sequence[int]) -> list[str]:
    """A short name of each of some frames."""
    times, kind = results["frames/time"], analysis_of(results)
    if kind == "modes":
        return [f"mode {frame}" if frame else "equilibrium" for frame in frames]
    return [f"{short(times[frame])}{' s' if kind == 'dynamics' else ''}" for frame in frames]


def short(time: float) -> str:
    """Three digits, of large numbers all before the point."""
    return f"{time:.0f}" if 1000.0 <= abs(time) < 1e6 else f"{time:.3g}"


def said(results: Results, frames: Sequence[int]) -> str:
    """Which frames these are, in words."""
    times, kind = results["frames/time"], analysis_of(results)
    if kind == "modes":
        return ", ".join(_mode(results, frame) for frame in frames)
    numbers = ", ".join(short(times[frame]) for frame in frames)
    return f"at {numbers} s" if kind == "dynamics" else f"at load factor {numbers}"


def _mode(results: Results, frame: int) -> str:
    """The first frame is the equilibrium, those after it are the modes in their order."""
    if frame == 0 or "modes/frequency" not in results:
        return "equilibrium"
    frequency = float(results["modes/frequency"][frame - 1])
    return f"mode {frame}: " + (f"{frequency:.4g} Hz" if frequency >= 0.0 else "unstable")
