"""Text of a CalculiX deck: nodes, elements, properties, loads that vary with time.

CalculiX reads numbers in fields of 20 characters, so that temperatures keep 14 digits, and allows
one load of a kind at a face or node; loads are therefore summed before they are written.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from meshes.materials import Property
from thermal.boundary import STEFAN_BOLTZMANN
from thermal.discretisation import Mean

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

COLDEST, HOTTEST = 1.0, 3000.0  # [K] of tables of properties that have no range of their own
SPACING = 2.5e-3  # of the temperature, between entries of a table of what is curved
RESIDUAL = 1e-8  # of the mean flux, and of the change of temperature, at which an increment ends
INCREMENTS = 100_000  # in one window
DIGITS = 13

AMPLITUDE_DIGITS = 14  # series that differ by less are one


class Table(NamedTuple):
    """Values (k,) at temperatures (k,) [K], linear in between; of one entry, a constant."""

    temperatures: Array
    values: Array


class Substance(NamedTuple):
    """What CalculiX knows of a material.

    density : float [kg/m^3]
    heat_capacity : [J/(kg K)]
    conductivities : [W/(m K)]  one, or three along the axes of the elements
    """

    density: float
    heat_capacity: Table
    conductivities: tuple[Table, ...]


class Elements(NamedTuple):
    """Elements of one type and material.

    kind : "C3D4", "C3D8", "C3D10", "C3D20" or "C3D20R"
    nodes : (m, k) intp  counted from 0
    axes : (m, 3, 3) float | None  rows: directions of the three conductivities
    factor : name of what comes from outside and multiplies the conductivity in each window
    """

    kind: str
    nodes: Indices
    substance: Substance
    axes: Array | None = None
    factor: str | None = None


class Model(NamedTuple):
    """All of a deck that does not change with time.

    x : (n, 3) float [m]
    ties : node -> the mean whose temperature it has
    """

    x: Array
    elements: Sequence[Elements]
    ties: Sequence[tuple[int, Mean]]


class Series(NamedTuple):
    """Magnitudes (m,) times amplitudes (a, k) at k times; ``which`` (m,) belongs to each."""

    magnitudes: Array
    which: Indices
    amplitudes: Array


def table(p: Property) -> Table:
    """A property as CalculiX interpolates it: exact where straight, dense where curved."""
    if p.is_constant:
        return Table(np.zeros(1), np.array([float(p(300.0))]))
    T = _entries(p)
    return Table(T, p(T))


def _entries(p: Property) -> Array:
    low, high = max(p.lower, COLDEST), min(p.upper, HOTTEST)
    knots = p.curve.knots[(p.curve.knots > low) & (p.curve.knots < high)]
    ends = np.concatenate([[low], knots, [high]])
    if not p.curve.value[:, 2:].any():
        return ends
    counts = np.ceil(np.log(ends[1:] / ends[:-1]) / SPACING).astype(int)
    pieces = [
        np.geomspace(a, b, max(n, 1) + 1)[:-1]
        for a, b, n in zip(ends, ends[1:], counts, strict=False)
    ]
    return np.concatenate([*pieces, ends[-1:]])


def series(values: Array) -> Series:
    """Split series (m, k) into magnitudes and few amplitudes."""
    magnitudes = np.abs(values).max(axis=1, initial=0.0)
    shapes = values / np.where(magnitudes > 0.0, magnitudes, 1.0)[:, None]
    shapes = np.round(shapes, AMPLITUDE_DIGITS) + 0.0  # no negative zeros
    amplitudes, which = np.unique(shapes, axis=0, return_inverse=True)
    return Series(magnitudes, which.ravel(), amplitudes)


# ---------------------------------------------------------------------------- what stays


def model_text(model: Model) -> str:
    """Nodes, elements, materials, ties."""
    lines = ["*NODE,NSET=NALL", *rows(np.arange(1, len(model.x) + 1), model.x)]
    first = 1
    for i, elements in enumerate(model.elements):
        lines += _elements(i, first, elements)
        first += len(elements.nodes)
    for node, mean in model.ties:
        lines += _equation(node, mean)
    constants = f"*PHYSICAL CONSTANTS,ABSOLUTE ZERO=0.,STEFAN BOLTZMANN={STEFAN_BOLTZMANN:.9e}"
    return "\n".join([*lines, constants, "*RESTART,WRITE,FREQUENCY=1", ""])


def with_factors(text: str, model: Model, factors: Mapping[str, float]) -> str:
    """The text of a model with the materials whose conductivities have a factor."""
    for i, elements in enumerate(model.elements):
        if elements.factor:
            own = elements.substance
            scaled = tuple(
                Table(t.temperatures, factors[elements.factor] * t.values)
                for t in own.conductivities
            )
            lines = _material(f"M{i}", own._replace(conductivities=scaled))
            text = text.replace(_mark(i), "\n".join(lines), 1)
    return text


def _mark(i: int) -> str:
    """A comment in the place of a material."""
    return f"** material {i} of this window"


def rows(numbers: Indices, values: Array) -> Iterator[str]:
    """Lines of a number and its values."""
    for number, row in zip(numbers.tolist(), values.tolist(), strict=True):
        yield f"{number}," + ",".join(f"{v:.{DIGITS}e}" for v in row)


def _elements(i: int, first: int, elements: Elements) -> list[str]:
    lines = [f"*ELEMENT,TYPE={elements.kind},ELSET=E{i}"]
    for number, nodes in enumerate((elements.nodes + 1).tolist(), first):
        lines += wrapped([number, *nodes], 15)
    lines += [_mark(i)] if elements.factor else _material(f"M{i}", elements.substance)
    if elements.axes is None:
        return [*lines, f"*SOLID SECTION,ELSET=E{i},MATERIAL=M{i}"]
    return lines + _oriented(i, first, elements.axes)


def _oriented(i: int, first: int, axes: Array) -> list[str]:
    """A section for each direction of the axes that occurs."""
    turned, which = np.unique(np.round(axes.reshape(-1, 9), 12), axis=0, return_inverse=True)
    lines = []
    for j, (along, around) in enumerate(turned[:, :6].reshape(-1, 2, 3).tolist()):
        name = f"{i}_{j}"
        lines += [f"*ORIENTATION,NAME=O{name},SYSTEM=RECTANGULAR"]
        lines += [",".join(f"{v:.{DIGITS}e}" for v in [*along, *around])]
        members = first + np.flatnonzero(which.ravel() == j)
        lines += [f"*ELSET,ELSET=E{name}", *wrapped(members.tolist(), 15, last=True)]
        lines += [f"*SOLID SECTION,ELSET=E{name},MATERIAL=M{i},ORIENTATION=O{name}"]
    return lines


def wrapped(numbers: Sequence[int], width: int, last: bool = False) -> list[str]:
    """Numbers in lines; but for the last one, each ends in a comma that continues it."""
    pieces = [numbers[i : i + width] for i in range(0, len(numbers), width)]
    lines = [",".join(map(str, piece)) + "," for piece in pieces]
    return lines if last else [*lines[:-1], lines[-1].rstrip(",")]


def _material(name: str, s: Substance) -> list[str]:
    lines = [f"*MATERIAL,NAME={name}", "*DENSITY", f"{s.density:.{DIGITS}e}"]
    lines += ["*SPECIFIC HEAT", *tabled((s.heat_capacity,))]
    kind = "ISO" if len(s.conductivities) == 1 else "ORTHO"
    return [*lines, f"*CONDUCTIVITY,TYPE={kind}", *tabled(s.conductivities)]


def tabled(tables: Sequence[Table]) -> list[str]:
    """Properties side by side at all temperatures of any of them."""
    T = np.unique(np.concatenate([t.temperatures for t in tables]))
    columns = [np.interp(T, t.temperatures, t.values) for t in tables]
    return [
        ",".join(f"{v:.{DIGITS}e}" for v in row) for row in np.column_stack([*columns, T]).tolist()
    ]


def _equation(node: int, mean: Mean) -> list[str]:
    terms = [(node, 1.0)]
    terms += [(n, -w) for n, w in zip(mean.nodes.tolist(), mean.weights.tolist(), strict=True) if w]
    cells = [f"{n + 1},11,{w:.{DIGITS}e}" for n, w in terms]
    lines = [",".join(cells[i : i + 4]) for i in range(0, len(cells), 4)]
    return ["*EQUATION", str(len(terms)), *lines]


# ------------------------------------------------------------------------- what varies


def initial_text(T: Array) -> list[str]:
    """Temperatures (n,) [K] at the start."""
    return ["*INITIAL CONDITIONS,TYPE=TEMPERATURE", *rows(np.arange(1, len(T) + 1), T[:, None])]


def amplitude_text(name: str, times: Array, values: Array) -> list[str]:
    """A function of time, counted from the start of the window."""
    pairs = np.column_stack([times, values]).tolist()
    cells = [f"{t:.{DIGITS}e},{v:.{DIGITS}e}" for t, v in pairs]
    head = f"*AMPLITUDE,NAME={name},TIME=TOTAL TIME"
    return [head, *(",".join(cells[i : i + 4]) for i in range(0, len(cells), 4))]


def amplitudes_text(name: str, times: Array, found: Series) -> list[str]:
    """All amplitudes of a kind of load, ``name`` and their number."""
    every = enumerate(found.amplitudes)
    return [line for i, row in every for line in amplitude_text(f"{name}{i}", times, row)]


def loads_text(keyword: str, name: str, targets: Sequence[str], found: Series) -> list[str]:
    """Loads on targets such as "12,S3", those of one amplitude together."""
    lines, order = [], np.argsort(found.which, kind="stable")
    last = -1
    for i in order.tolist():
        if found.which[i] != last:
            last = int(found.which[i])
            lines.append(f"*{keyword},AMPLITUDE={name}{last}")
        lines.append(f"{targets[i]},{found.magnitudes[i]:.{DIGITS}e}")
    return lines


def steps_text(procedure: Sequence[str], loads: Iterable[str]) -> list[str]:
    """One step for each procedure; loads given in the first stay."""
    lines: list[str] = []
    for i, lines_of_one in enumerate(procedure):
        lines += [f"*STEP,INC={INCREMENTS}", *lines_of_one.splitlines()]
        lines += ["*CONTROLS,PARAMETERS=FIELD", f"{RESIDUAL},{RESIDUAL},,,{RESIDUAL}"]
        lines += [] if i else [*loads, "*NODE PRINT,NSET=NALL", "NT"]
        lines.append("*END STEP")
    return lines


def equal_increments(h: float, count: int) -> list[str]:
    """Procedures of ``count`` equal increments within ``h`` [s]."""
    return [f"*HEAT TRANSFER,DIRECT\n{h / count:.{DIGITS}e},{h / count:.{DIGITS}e}"] * count


def limited_increments(h: float, largest_change: float) -> list[str]:
    """Procedure whose increments change no temperature by more than ``largest_change`` [K]."""
    head = f"*HEAT TRANSFER,DELTMX={largest_change:.6e}"
    return [f"{head}\n{h:.{DIGITS}e},{h:.{DIGITS}e},{1e-9 * h:.6e},{h:.{DIGITS}e}"]


STEADY = ["*HEAT TRANSFER,STEADY STATE\n1.,1."]
