"""Heat shocks: how far temperatures fall below the coldest boundary, over schemes and step lengths.

One end of an insulated bar jumps, or falls at 25 K/s from 200 to -50 degC as in Hua et al. (2026).
What is exact stays between the coldest and the hottest of start and boundary. Properties are
constant, so that to exceed the hottest in a cold shock is to fall below the coldest in a hot one:
both count. Temperatures are counted from 1000 K less, lest what falls below 0 K is refused.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from coupling.reports.registry import Curve, Picture, Result, Row
from coupling.verify.heat import bar, calculix_is_there, conductor
from meshes.sections import circle, tube
from meshes.solids import box
from thermal import solvers
from thermal.description import Description, Fixed, Member, Place, Settings, Solid

Array = NDArray[np.float64]

HOT, COLD, RATE = 1473.15, 1223.15, 25.0  # [K], 1000 K more than in fact; [K/s]
LENGTH, ELEMENTS = 0.1, 10
ALUMINIUM = conductor(167.0, 2700.0, 896.0)
DIFFUSIVITY = 167.0 / 2700.0 / 896.0  # [m^2/s]
SIZE = LENGTH / ELEMENTS
FOURIER = tuple(10.0**e for e in range(-3, 7))
"""Steps times diffusivity over the square of the size of elements."""
STEPS = 20  # windows in a row, of equal length, after the jump
SCHEMES = ("backward-euler", "sdirk2", "crank-nicolson")
OWN, CONTROLLED = "tr-bdf2", "sdirk2, controlled"
"""That of ``lumped`` where no other is named; by default, with steps within a window chosen by the
estimated error (1e-3 K)."""


class Kind(NamedTuple):
    """A solver with settings other than the schemes.

    schemes : those to try
    made : what is shocked at its place "start"
    windows : in a row
    """

    solver: str
    schemes: tuple[str, ...] = (*SCHEMES, CONTROLLED)
    settings: Mapping[str, Any] = {}
    made: Callable[[], Member | Solid] = lambda: bar(LENGTH, ELEMENTS, HOT, material=ALUMINIUM)
    windows: int = STEPS


def _pipe() -> Member:
    return bar(LENGTH, ELEMENTS, HOT, tube(0.02, 0.002), ALUMINIUM, 8)


def _round() -> Member:
    return bar(LENGTH, ELEMENTS, HOT, circle(0.02), ALUMINIUM)


def _plate(width: float) -> Solid:
    """Square, of cells of 10 mm x ``width``, half of whose face y0 is shocked."""
    cells = (ELEMENTS, round(LENGTH / width), 1)
    mesh = box((LENGTH, LENGTH, SIZE), cells)
    family, rows = mesh.regions["y0"]
    near = mesh.points[mesh.cells[family][rows]][..., 0].mean(axis=1) < 0.5 * LENGTH
    regions = {**mesh.regions, "start": (family, rows[near])}
    return Solid("plate", replace(mesh, regions=regions), {"": ALUMINIUM}, HOT)


KINDS = {
    "line": Kind("line"),
    "line, tube": Kind("line", made=_pipe),
    "wall, tube": Kind("wall", made=_pipe),
    "wall, tube, order 2": Kind("wall", settings={"order": 2}, made=_pipe),
    "lumped": Kind("lumped", ("backward-euler", "crank-nicolson", OWN)),
    "lumped, tube": Kind("lumped", ("backward-euler", "crank-nicolson", OWN), made=_pipe),
    "solid": Kind("solid"),
    "solid, tube": Kind("solid", made=_pipe),
    "solid, circle": Kind("solid", made=_round),
    "solid, half a face": Kind("solid", made=lambda: _plate(SIZE)),
    "solid, half a face, cells 1:5": Kind("solid", made=lambda: _plate(5.0 * SIZE)),
    "solid, consistent": Kind("solid", settings={"capacity": "consistent"}),
    "solid, order 2": Kind("solid", SCHEMES, {"order": 2}),
    "hermite": Kind("hermite"),
    "calculix": Kind("calculix", SCHEMES[:1], windows=3),
}
"""What is tried."""
COLUMNS = ("solver", "scheme", "shock", *(f"{Fo:g}" for Fo in FOURIER), "largest [%]")


def report() -> Iterator[Result]:
    """The table and its pictures."""
    rows = [row for shock in SHOCKS for name in there() for row in rows_of(name, shock)]
    notes = [
        f"how far temperatures leave the range of start and boundary in % of the {HOT - COLD:g} K, "
        f"the largest within {STEPS} equal windows",
        "heads: length of a window x diffusivity / (size of elements)^2; windows are single steps "
        "but where steps are controlled",
        f"ramp: by {RATE:g} K/s",
        "of hermite at its nodes; CalculiX only backward Euler, 3 windows",
    ]
    for shock in SHOCKS:
        dry = [f"{r[0]}, {r[1]}" for r in rows if r[2] == shock and float(r[-1]) <= ROUND_OFF]
        notes.append(f"{shock}, none beyond round-off: {'; '.join(dry) or 'none'}")
    pictures = [_picture(scheme, rows) for scheme in (*SCHEMES, OWN, CONTROLLED)]
    yield Result(
        "heat_shock", "Heat shocks: how far the range is left", COLUMNS, rows, notes, pictures
    )


ROUND_OFF = 1e-9
"""Undershoot that counts as none [%]."""


def there() -> list[str]:
    """Kinds whose solver is there."""
    return [n for n, kind in KINDS.items() if kind.solver != "calculix" or calculix_is_there()]


def rows_of(name: str, shock: str) -> Iterator[Row]:
    """A row for each scheme of a kind."""
    for scheme in KINDS[name].schemes:
        found = [undershoot(name, scheme, Fo, shock) for Fo in FOURIER]
        yield (name, scheme, shock, *found, max(found))


def undershoot(name: str, scheme: str, Fo: float, shock: str = "jump") -> float:
    """How far temperatures leave the range of start and boundary within some steps [%]."""
    kind, h = KINDS[name], Fo * SIZE**2 / DIFFUSIVITY
    solver = built(kind, scheme, shock)
    T, beyond = solver.initial(), 0.0
    nodes = np.concatenate(list(solver.regions.values()))
    for i in range(kind.windows):
        t = i * h
        T, _, why = solver.advance(T, t, h, np.zeros_like(T))
        if why:
            return float("nan")
        coldest = SHOCKS[shock](t + h)
        beyond = max(beyond, coldest - float(T[nodes].min()), float(T[nodes].max()) - HOT)
    return 100.0 * beyond / (HOT - COLD)


def built(kind: Kind, scheme: str, shock: str) -> Any:
    """A solver that makes one step of each window."""
    thing = kind.made()
    face = (Fixed("face", Place(thing.name, "start"), SHOCKS[shock]),)
    if isinstance(thing, Solid):
        d = Description(solids=(thing,), conditions=face)
    else:
        d = Description((thing,), conditions=face)
    steps = None if scheme == CONTROLLED else 1
    named = scheme if scheme in SCHEMES else "sdirk2"
    return solvers.build(kind.solver, d, Settings(scheme=named, steps=steps, **kind.settings))


def jump(t: float) -> float:
    """Cold from the first on."""
    return COLD


def ramp(t: float) -> float:
    """Falls at 25 K/s until it is cold."""
    return max(COLD, HOT - RATE * t)


SHOCKS = {"jump": jump, "ramp": ramp}


def _picture(scheme: str, rows: list[Row]) -> Picture:
    """Of the jump; kinds that agree are one curve."""
    alike: dict[tuple[float, ...], list[str]] = {}
    for r in rows:
        if r[1] == scheme and r[2] == "jump":
            alike.setdefault(tuple(round(float(v), 1) for v in r[3:-1]), []).append(str(r[0]))
    curves = [Curve(_label(names), FOURIER, values) for values, names in alike.items()]
    return Picture("Fourier number of a step [-]", f"{scheme}\nleft by [%]", curves, "x")


def _label(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{names[0]}, and {len(names) - 1} alike"
