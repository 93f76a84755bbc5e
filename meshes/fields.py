"""Temperature fields T(x, t) from tables and from files, as other codes export them.

A field takes positions (n, 3) [m] and a time [s] and gives temperatures (n,) [K]. It is known at
``times`` (first, last) only: at other times it gives NaN. Positions too far from the data are a
``ValueError``. Between points of a file the field is a local linear least-squares fit over the
nearest points with weights that fall with distance (Franke & Nielson 1980), so that fields linear
in space are met exactly, on lines and surfaces too, and the points' own values at the points.
In time it is linear.
"""

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from meshes.io import load

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

ALWAYS = (-np.inf, np.inf)
LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "in": 0.0254, "ft": 0.3048}
TEMPERATURES = {"K": (1.0, 0.0), "degC": (1.0, 273.15), "degF": (5.0 / 9.0, 459.67 * 5.0 / 9.0)}
"""Unit -> factor and offset [K]."""
NAMES = ("temperature", "temp", "t", "nt", "nt11", "ndtemp")
"""What arrays of temperature are called in files, in any case."""

FEW, MANY = 16, 512  # points of a fit; more, up to the second, where they miss a direction
TOGETHER = 200_000  # points of all fits that are made at once
FLAT = 1e-4  # extent in a direction, relative to the largest, below which points have none in it
APART = 1e-2  # distance from the plane of the points, likewise, at which more points are asked for
FAR = 1.0  # distance from the nearest point in extents of the points of a fit
TIMES_SLACK = 1e-9  # relative


class Units(NamedTuple):
    """Of length and temperature in a file."""

    length: str = "m"
    temperature: str = "K"

    def require_known(self) -> None:
        """Raise ValueError for units that are not known."""
        found = [
            f"unit of {what} '{unit}' is not known; there are {', '.join(known)}"
            for what, unit, known in (
                ("length", self.length, LENGTHS),
                ("temperature", self.temperature, TEMPERATURES),
            )
            if unit not in known
        ]
        if found:
            raise ValueError("; ".join(found))

    def kelvin(self, values: Array) -> Array:
        """[K]"""
        factor, offset = TEMPERATURES[self.temperature]
        return factor * values + offset

    def metres(self, points: Array) -> Array:
        """[m]"""
        return LENGTHS[self.length] * points


SI = Units()


class Frame(NamedTuple):
    """The field at one time.

    points : (n, 3) float [m], values : (n,) float [K]
    """

    time: float
    points: Array
    values: Array


class SampledField:
    """Temperatures at points, at one or more times.

    Parameters
    ----------
    frames : with times that rise; frames that share points should share the array
    source : named in errors

    Attributes
    ----------
    times : (first, last) float [s]; of a single frame all times
    """

    def __init__(self, frames: Sequence[Frame], source: str) -> None:
        self.frames, self.source = list(frames), source
        self._instants = np.array([frame.time for frame in frames])
        self.times = (frames[0].time, frames[-1].time) if len(frames) > 1 else ALWAYS
        self._trees = {id(frame.points): cKDTree(frame.points) for frame in frames}
        self._fits: dict[tuple[int, bytes], csr_array] = {}

    def __call__(self, points: Array, t: float) -> Array:
        """(n,) [K] at ``points`` (n, 3) [m] and time ``t`` [s]."""
        if len(self.frames) == 1:
            return self._at(self.frames[0], points)
        i, along = _between(self._instants, t)
        if np.isnan(along):
            return np.full(len(points), np.nan)
        a, b = (self._at(frame, points) for frame in self.frames[i : i + 2])
        return (1.0 - along) * a + along * b

    def _at(self, frame: Frame, points: Array) -> Array:
        """Weights are kept, as the same positions are asked for at every time."""
        key = id(frame.points), np.ascontiguousarray(points, dtype=float).tobytes()
        if key not in self._fits:
            try:
                self._fits[key] = _weights(self._trees[key[0]], np.asarray(points, dtype=float))
            except ValueError as error:
                raise ValueError(f"{self.source}: {error}") from None
        return self._fits[key] @ frame.values


class TableField:
    """T(s, t) along a line, linear between the values of a table; see ``table_field``."""

    def __init__(self, times: Array, distances: Array, values: Array, line: Array) -> None:
        self._instants, self._distances, self._values = times, distances, values
        self._line = line
        self.times = (float(times[0]), float(times[-1])) if len(times) > 1 else ALWAYS

    def __call__(self, points: Array, t: float) -> Array:
        """(n,) [K] at ``points`` (n, 3) [m] and time ``t`` [s]."""
        s, first, last = along_line(self._line, points), self._distances[0], self._distances[-1]
        slack = 1e-6 * max(last - first, float(np.ptp(s)))
        outside = s[(s < first - slack) | (s > last + slack)]
        if len(outside):
            raise ValueError(
                f"the table goes from {first:g} m to {last:g} m, {outside[0]:g} m is asked for"
            )
        if len(self._instants) == 1:
            return np.interp(s, self._distances, self._values[0])
        i, along = _between(self._instants, t)
        if np.isnan(along):
            return np.full(len(s), np.nan)
        a, b = (np.interp(s, self._distances, row) for row in self._values[i : i + 2])
        return (1.0 - along) * a + along * b


Field = SampledField | TableField


def table_field(
    times: ArrayLike, distances: ArrayLike, values: ArrayLike, line: ArrayLike
) -> TableField:
    """Temperatures along a line, by arclength.

    Parameters
    ----------
    times : (n_t,) float [s]  rising; of one time the field is the same for ever
    distances : (n_s,) float [m]  rising; where the line is asked for must lie among them
    values : (n_t, n_s) float [K]
    line : (n, 3) float [m]  polyline from which distances count; positions are taken to their
        nearest point on it
    """
    t, s = np.atleast_1d(np.asarray(times, float)), np.atleast_1d(np.asarray(distances, float))
    T, x = np.asarray(values, dtype=float), np.asarray(line, dtype=float)
    found = [
        f"{what} must be finite and rise"
        for what, a in (("times", t), ("distances", s))
        if not (a.ndim == 1 and np.isfinite(a).all() and (np.diff(a) > 0.0).all())
    ]
    if T.shape != (t.size, s.size):
        found.append(f"values must have the shape {(t.size, s.size)}, got {T.shape}")
    elif not (np.isfinite(T).all() and (T > 0.0).all()):
        found.append("values must be finite and above 0 K")
    if x.ndim != 2 or x.shape[1] != 3 or len(x) < 2 or not np.isfinite(x).all():
        found.append(f"a line needs two or more points of three coordinates, got {x.shape}")
    if found:
        raise ValueError("\n  ".join(["table of temperatures", *found]))
    return TableField(t, s, T, x)


def along_line(line: Array, points: Array) -> Array:
    """(n,) [m]  arclength of the point of a polyline that is nearest to each of ``points``."""
    edges = np.diff(line, axis=0)
    lengths = np.linalg.norm(edges, axis=1)
    starts = np.concatenate([[0.0], np.cumsum(lengths)[:-1]])
    nearest, s = np.full(len(points), np.inf), np.zeros(len(points))
    for x, edge, length, start in zip(line, edges, lengths, starts, strict=False):
        if length > 0.0:
            along = np.clip((points - x) @ edge / length, 0.0, length)
            distance = np.linalg.norm(points - x - along[:, None] / length * edge, axis=1)
            closer = distance < nearest
            nearest, s = np.where(closer, distance, nearest), np.where(closer, start + along, s)
    return s


def read_field(
    path: str | PathLike[str], units: Units = SI, array: str | None = None
) -> SampledField:
    """Read a field from a file.

    .csv : columns x, y, z, temperature and, of fields that change, time [s]; other columns are
        not looked at. Separated by commas, semicolons or tabs; a unit in brackets behind a name,
        such as ``x [mm]``, counts before ``units``
    .vtu, .vtk : temperatures of points, or of cells at their centres
    .pvd : a series of such files with their times [s]

    Parameters
    ----------
    units : of lengths and temperatures in the file
    array : name of the temperatures; None: the one with a usual name, such as "temperature", "NT"
    """
    path = Path(path)
    readers: dict[str, Callable[[Path, Units, str | None], list[Frame]]] = {
        ".csv": _read_csv, ".vtu": _read_mesh, ".vtk": _read_mesh, ".pvd": _read_series,
    }  # fmt: skip
    if path.suffix.lower() not in readers:
        raise ValueError(f"{path}: fields are read from {', '.join(readers)} files only")
    if not path.is_file():
        raise ValueError(f"{path}: there is no such file")
    try:
        units.require_known()
        frames = readers[path.suffix.lower()](path, units, array)
        _require_sound(frames)
    except ValueError as error:
        said = str(error)
        raise ValueError(said if said.startswith(str(path)) else f"{path}: {said}") from None
    return SampledField(_shared(frames), str(path))


# ------------------------------------------------------------------------------- interpolation


def _between(instants: Array, t: float) -> tuple[int, float]:
    """The interval of ``t`` and how far in it, 0 to 1; NaN outside of all."""
    slack = TIMES_SLACK * max(abs(t), float(instants[-1] - instants[0]))
    if not instants[0] - slack <= t <= instants[-1] + slack:
        return 0, np.nan
    i = int(np.clip(np.searchsorted(instants, t, side="right") - 1, 0, len(instants) - 2))
    along = (t - instants[i]) / (instants[i + 1] - instants[i])
    return i, float(np.clip(along, 0.0, 1.0))


def _weights(tree: cKDTree, points: Array) -> csr_array:
    """(m, n)  from values at the points of ``tree`` to those at ``points`` (m, 3)."""
    found = [(np.empty(0, np.intp), np.empty(0, np.intp), np.empty(0))]
    extents = np.zeros(len(points))
    nearest = tree.query(points)[0]
    left, count = np.arange(len(points)), min(FEW, tree.n)
    while len(left):
        again = []
        for chunk in np.array_split(left, 1 + len(left) * count // TOGETHER):
            distances, near = (a.reshape(-1, count) for a in tree.query(points[chunk], k=count))
            weights, complete, extents[chunk] = _fit(tree.data[near], points[chunk], distances)
            done = complete | (count >= min(MANY, tree.n))
            again.append(chunk[np.logical_not(done)])
            rows = np.repeat(chunk[done], count)
            found.append((rows, near[done].ravel(), weights[done].ravel()))
        left, count = np.concatenate(again), min(2 * count, tree.n)
    _require_near(points, nearest, extents)
    rows, columns, entries = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return csr_array((entries, (rows, columns)), shape=(len(points), tree.n))


def _fit(near: Array, at: Array, distances: Array) -> tuple[Array, Array, Array]:
    """Weights (m, k) of linear fits to points (m, k, 3); whether they reach there; extents.

    Directions in which the points have no extent are left out of the fit.
    """
    centres = near.mean(axis=1)
    away, own = near - centres[:, None], at - centres
    _, sizes, axes = np.linalg.svd(away, full_matrices=False)
    spread = np.zeros((len(at), 3))
    spread[:, : sizes.shape[1]] = sizes
    axes = np.concatenate([axes, np.zeros((len(at), 3 - axes.shape[1], 3))], axis=1)
    extent = 2.0 * np.linalg.norm(away, axis=2).max(axis=1)
    kept = (spread > FLAT * spread[:, :1]) & (spread > 0.0)
    scale = np.where(kept, 1.0 / np.where(kept, spread, 1.0), 0.0)
    basis = np.einsum("mkc,mdc,md->mkd", away, axes, scale)
    target = np.einsum("mc,mdc,md->md", own, axes, scale)
    across = np.linalg.norm(own - np.einsum("md,mdc,md->mc", target, axes, spread), axis=1)
    basis = np.concatenate([np.ones((*basis.shape[:2], 1)), basis], axis=2)
    target = np.concatenate([np.ones((len(at), 1)), target], axis=1)
    closeness = _closeness(distances)[..., None]
    maps = np.linalg.pinv(closeness * basis, rcond=1e-13)
    return (
        np.einsum("md,mdk->mk", target, maps) * closeness[..., 0],
        across <= APART * extent,
        extent,
    )


def _closeness(distances: Array) -> Array:
    """Square roots of weights: (D - d) / (D d) with D beyond the farthest, finite at d = 0."""
    far = 1.1 * distances[:, -1:] + np.finfo(float).tiny
    return (far - distances) / (distances + 1e-6 * far)


def _require_near(points: Array, nearest: Array, extent: Array) -> None:
    far = nearest > FAR * extent
    if far.any():
        i = int(np.argmax(np.where(far, nearest, -1.0)))
        x, y, z = points[i]
        raise ValueError(
            f"{far.sum()} of {len(far)} positions are far from the data; that at "
            f"({x:g}, {y:g}, {z:g}) m is {nearest[i]:g} m from the nearest point (unit of length?)"
        )


# --------------------------------------------------------------------------------------- files


def _require_sound(frames: Sequence[Frame]) -> None:
    for frame in frames:
        if len(frame.points) < 2:
            raise ValueError("a field needs two or more points")
        if not np.isfinite(frame.points).all():
            raise ValueError("a coordinate is not a finite number")
        if not np.isfinite(frame.values).all():
            raise ValueError(f"{np.sum(~np.isfinite(frame.values))} temperatures are not numbers")
        if not frame.values.min() > 0.0:
            raise ValueError(
                f"a temperature of {frame.values.min():g} K is not above 0 K (unit of temperature?)"
            )


def _shared(frames: Sequence[Frame]) -> list[Frame]:
    """Frames with equal points share one array."""
    shared: list[Frame] = []
    for frame in frames:
        same = bool(shared) and np.array_equal(shared[-1].points, frame.points)
        shared.append(frame._replace(points=shared[-1].points) if same else frame)
    return shared


def _read_csv(path: Path, units: Units, array: str | None) -> list[Frame]:
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise ValueError("is not a text file") from None
    kept = [(i, text) for i, text in enumerate(lines, 1) if text.strip() and text[0] != "#"]
    if len(kept) < 2:
        raise ValueError("has no rows")
    header, *rows = csv.reader([text for _, text in kept], delimiter=_delimiter(kept[0][1]))
    columns, units = _columns(header, units, array)
    table = np.array(list(_numbers(rows, [i for i, _ in kept[1:]], columns)))
    points, values = units.metres(table[:, :3]), units.kelvin(table[:, 3])
    times = table[:, 4] if "time" in columns else np.zeros(len(table))
    return [Frame(float(t), points[times == t], values[times == t]) for t in np.unique(times)]


def _delimiter(header: str) -> str:
    return max(",;\t", key=header.count)


def _columns(
    header: Sequence[str], units: Units, array: str | None
) -> tuple[Mapping[str, int], Units]:
    """Which column is x, y, z, temperature and, if there is one, time; units named there."""
    names, given = zip(*(_name_and_unit(text) for text in header), strict=True)
    wanted = {name: [name] for name in ("x", "y", "z")}
    wanted["temperature"] = list(NAMES) if array is None else [array.lower()]
    wanted["time"] = ["time"]
    where = {k: [i for i, n in enumerate(names) if n in any_of] for k, any_of in wanted.items()}
    found = [f"no column '{k}'" for k, i in where.items() if not i and k != "time"]
    found += [f"{len(i)} columns for '{k}'" for k, i in where.items() if len(i) > 1]
    if found:
        raise ValueError(f"{', '.join(found)}; its columns are {', '.join(header)}")
    columns = {k: i[0] for k, i in where.items() if i}
    lengths = {given[columns[k]] for k in ("x", "y", "z")}
    if len(lengths) > 1 or given[columns.get("time", 0)] not in ("", "s", *lengths):
        raise ValueError("x, y and z need the same unit, and time is in s")
    units = Units(lengths.pop() or units.length, given[columns["temperature"]] or units.temperature)
    units.require_known()
    return columns, units


def _name_and_unit(text: str) -> tuple[str, str]:
    name, _, unit = text.strip().strip('"').partition("[")
    return name.strip().lower(), unit.strip(" ]")


def _numbers(
    rows: Sequence[Sequence[str]], lines: Sequence[int], columns: Mapping[str, int]
) -> Iterator[list[float]]:
    for row, line in zip(rows, lines, strict=True):
        numbers = []
        for name, column in columns.items():
            text = row[column].strip() if column < len(row) else ""
            try:
                numbers.append(float(text))
            except ValueError:
                raise ValueError(f"line {line}: '{text}' for {name} is not a number") from None
            if not np.isfinite(numbers[-1]):
                raise ValueError(f"line {line}: {name} is {text}, not a finite number")
        yield numbers


def _read_mesh(path: Path, units: Units, array: str | None) -> list[Frame]:
    raw = load(path)
    points = np.zeros((len(raw.points), 3))
    points[:, : raw.points.shape[1]] = raw.points
    name, of_cells = _array_of(raw, array)
    if of_cells:
        centres = [points[block.data].mean(axis=1) for block in raw.cells]
        points, values = np.concatenate(centres), np.concatenate(raw.cell_data[name])
    else:
        values = raw.point_data[name]
    values = np.asarray(values, dtype=float)
    if values.shape not in ((len(points),), (len(points), 1)):
        raise ValueError(f"array '{name}' has the shape {values.shape}, not one value per point")
    return [Frame(0.0, units.metres(points), units.kelvin(values.ravel()))]


def _array_of(raw, array: str | None) -> tuple[str, bool]:
    """Name of the temperatures, and whether they are those of cells."""
    every = [(name, False) for name in raw.point_data] + [(name, True) for name in raw.cell_data]
    if array is not None:
        chosen = [pair for pair in every if pair[0] == array]
    else:
        chosen = [pair for pair in every if pair[0].lower() in NAMES]
    if not chosen or (len({name for name, _ in chosen}) > 1):
        what = "temperatures" if array is None else f"'{array}'"
        there = ", ".join(f"'{name}'" for name, _ in every) or "none"
        raise ValueError(f"which array holds {what} is not clear; its arrays are {there}")
    return chosen[0]


def _read_series(path: Path, units: Units, array: str | None) -> list[Frame]:
    try:
        root = ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, UnicodeDecodeError, LookupError) as error:
        raise ValueError(f"cannot be read as a series: {error}") from None
    parts: dict[float, list[Frame]] = {}
    for entry in root.iter("DataSet"):
        t = _instant(entry.get("timestep", ""))
        named = path.parent / entry.get("file", "")
        if named.suffix.lower() not in (".vtu", ".vtk") or not named.is_file():
            raise ValueError(f"names '{entry.get('file', '')}', which is no .vtu or .vtk file")
        try:
            parts.setdefault(t, []).extend(_read_mesh(named, units, array))
        except ValueError as error:
            raise ValueError(f"'{named.name}': {error}") from None
    if not parts:
        raise ValueError("has no data sets")
    return [_joined(t, parts[t]) for t in sorted(parts)]


def _instant(text: str) -> float:
    try:
        t = float(text)
    except ValueError:
        t = np.nan
    if not np.isfinite(t):
        raise ValueError(f"time '{text}' is not a number")
    return t


def _joined(t: float, frames: Sequence[Frame]) -> Frame:
    points, values = (np.concatenate([frame[k] for frame in frames]) for k in (1, 2))
    return Frame(t, points, values)
