"""What acts on a CalculiX model over a window: amplitudes, and loads that refer to them.

CalculiX counts the rate of temperature at free nodes only. What free nodes store because the
prescribed temperatures beside them change it leaves out: an error of the order of the size of the
cells, but no undershoot beside a shock. Where it is not to be left out it is a load here.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thermal.calculix_deck import amplitude_text, amplitudes_text, loads_text, series
from thermal.calculix_model import Assembled, Faces
from thermal.description import (
    Description,
    Enclosure,
    Film,
    Flux,
    History,
    Irradiation,
    Radiation,
    Side,
    Source,
)
from thermal.discretisation import Discretisation, Face

Array = NDArray[np.float64]
Outside = Mapping[str, tuple[Array, Array]]
Facet = tuple[int, int]

CLOSED = -1.0  # a sink below zero tells CalculiX to make the view factors of each facet sum to one


class Window(NamedTuple):
    """A window and what comes from outside in it.

    times : (k,) float [s]  of CalculiX, from 0 on, at which histories are taken; linear in between
    moments : (k,) float [s]  of the histories, at these times
    T : (n,) float [K]  at its start
    jumps : whether ``times`` are the ends of all increments, so that prescribed temperatures that
        jump at the start are seen to rise within the first of them
    heat : (n,) float [W]  given to the temperatures
    outside : name -> values at its start and end
    """

    times: Array
    moments: Array
    T: Array
    jumps: bool
    heat: Array
    outside: Outside

    def of(self, history: History) -> Array:
        """(k,)  a history at the times of the window."""
        return np.array([history(float(t)) for t in self.moments])


class Patch(NamedTuple):
    """Facets of a face; factors (m,) of the density of a condition."""

    facets: list[Facet]
    factors: Array


class Loads:
    """The loads of a description on an assembled model.

    Parameters
    ----------
    couples : whether what free nodes store as prescribed ones change is a load
    """

    def __init__(
        self, d: Description, space: Discretisation, assembled: Assembled, couples: bool
    ) -> None:
        self._space, self._held, self._couples = space, assembled.held, couples
        self._fluxes = [
            (c, _facing(space.face(Side(c.body, c.face)), c.direction, assembled.faces))
            for c in d.conditions
            if isinstance(c, Flux)
        ]
        self._lit = [
            (c, space.irradiated(Side(c.body, c.face)), assembled.faces)
            for c in d.conditions
            if isinstance(c, Irradiation)
        ]
        self._sources = [(c, space.place(c.place)) for c in d.conditions if isinstance(c, Source)]
        self._films = [
            (c, _facets(space.face(Side(c.body, c.face)), assembled.faces))
            for c in d.conditions
            if isinstance(c, Film)
        ]
        self._radiations = [
            (c, _facets(space.face(Side(c.body, c.face)), assembled.faces))
            for c in d.conditions
            if isinstance(c, Radiation)
        ]
        self._enclosures = [
            (c, [_facets(space.face(side), assembled.faces) for side in c.sides])
            for c in d.conditions
            if isinstance(c, Enclosure)
        ]
        self._members = {m.name for m in d.members}

    def problems(self) -> list[str]:
        """Faces with two conditions of a kind of which CalculiX takes one."""
        found = []
        films = [(c.name, facets) for c, facets in self._films]
        radiations = [(c.name, facets) for c, facets in self._radiations]
        radiations += [(e.name, f) for e, sides in self._enclosures for f in sides]
        for kind, named in (("films", films), ("radiations", radiations)):
            owner: dict[Facet, str] = {}
            for name, facets in named:
                found += [
                    f"'{other}' and '{name}': CalculiX takes no two {kind} on the same face"
                    for other in sorted({owner[f] for f in facets if f in owner})
                ]
                owner |= dict.fromkeys(facets, name)
        return found

    def text(self, window: Window) -> tuple[list[str], list[str]]:
        """Lines of amplitudes, and of loads."""
        amplitudes: list[str] = []
        loads: list[str] = []
        parts = [
            ("BOUNDARY", "B", self._given(window)),
            ("CFLUX", "C", self._powers(window)),
            ("DFLUX", "D", self._densities(window)),
        ]
        for keyword, name, (targets, values) in parts:
            if targets:
                found = series(values)
                amplitudes += amplitudes_text(name, window.times, found)
                loads += loads_text(keyword, name, targets, found)
        for lines, more in (self._film_text(window), self._radiation_text(window)):
            amplitudes += lines
            loads += more
        return amplitudes, loads

    def _given(self, window: Window) -> tuple[list[str], Array]:
        nodes, values = [], [np.empty((0, len(window.times)))]
        for g in self._space.given:
            nodes += g.nodes.tolist()
            values.append(np.stack([g.at(float(t)) for t in window.moments], axis=1))
        for held in self._held:
            nodes += held.nodes.tolist()
            values.append(np.tile(window.of(held.temperature), (len(held.nodes), 1)))
        return [f"{node + 1},11,11" for node in nodes], np.vstack(values)

    def _powers(self, window: Window) -> tuple[list[str], Array]:
        powers = np.tile(window.heat[:, None], (1, len(window.times)))
        if self._couples:
            powers -= self._left_out(window)
        for c, mean in self._sources:
            np.add.at(powers, mean.nodes, np.outer(mean.weights, window.of(c.power)))
        nodes = np.flatnonzero(powers.any(axis=1))
        return [f"{node + 1},11" for node in nodes.tolist()], powers[nodes]

    def _left_out(self, window: Window) -> Array:
        """(n, k) [W] that free temperatures store as those prescribed beside them change."""
        given = list(self._space.given)
        nodes = np.concatenate([np.empty(0, np.intp), *(g.nodes for g in given)])
        T, stored = window.T.copy(), []
        for t in window.moments:
            T[nodes] = np.concatenate([np.empty(0), *(g.at(float(t)) for g in given)])
            stored.append(self._space.heat(T))
        if window.jumps:
            stored[0] = self._space.heat(window.T)
        rates = np.diff(np.stack(stored, axis=1)) / np.diff(window.times)
        rates[nodes] = 0.0
        return np.hstack([rates[:, :1], rates])

    def _densities(self, window: Window) -> tuple[list[str], Array]:
        """Flux densities of all conditions together."""
        total: dict[Facet, Array] = {}
        for c, patch in self._fluxes:
            _add(total, patch, window.of(c.density))
        for lit, face, faces in self._lit:
            ends = window.outside[lit.name]
            for patch, along in _irradiated(face, faces, ends, window.times):
                _add(total, patch, along)
        kept = {facet: row for facet, row in total.items() if row.any()}
        targets = [f"{element},S{side}" for element, side in kept]
        return targets, np.array(list(kept.values())).reshape(-1, len(window.times))

    def _film_text(self, window: Window) -> tuple[list[str], list[str]]:
        amplitudes, loads = [], []
        for i, (c, facets) in enumerate(self._films):
            amplitudes += amplitude_text(f"FS{i}", window.times, window.of(c.surroundings))
            amplitudes += amplitude_text(f"FH{i}", window.times, window.of(c.coefficient))
            loads.append(f"*FILM,AMPLITUDE=FS{i},FILM AMPLITUDE=FH{i}")
            loads += [f"{element},F{side},1.,1." for element, side in facets]
        return amplitudes, loads

    def _radiation_text(self, window: Window) -> tuple[list[str], list[str]]:
        amplitudes, loads = [], []
        for i, (c, facets) in enumerate(self._radiations):
            amplitudes += amplitude_text(f"RS{i}", window.times, window.of(c.sink))
            loads.append(f"*RADIATE,AMPLITUDE=RS{i}")
            loads += [f"{element},R{side},1.,{c.emissivity:.13e}" for element, side in facets]
        for i, (e, sides) in enumerate(self._enclosures):
            sink = np.zeros(len(window.times)) if e.sink is None else window.of(e.sink)
            if self._is_long(e):
                sink = np.full(len(window.times), CLOSED)
            amplitudes += amplitude_text(f"ES{i}", window.times, sink)
            loads.append(f"*RADIATE,AMPLITUDE=ES{i},CAVITY=C{i:02d}")
            for facets, emissivity in zip(sides, e.emissivities, strict=True):
                loads += [f"{el},R{side}CR,1.,{emissivity:.13e}" for el, side in facets]
        return amplitudes, loads

    def _is_long(self, e: Enclosure) -> bool:
        """Whether it is the inside of a tube, whose stations exchange each with itself."""
        (first, *others) = e.sides
        return not others and first.face == "inner" and first.thing in self._members


def _add(total: dict[Facet, Array], patch: Patch, along: Array) -> None:
    for facet, factor in zip(patch.facets, patch.factors, strict=True):
        total[facet] = total.get(facet, 0.0) + factor * along


def _facets(face: Face, faces: Faces) -> list[Facet]:
    return [facet for block in face for facet in faces.find(block)]


def _facing(face: Face, direction: Array | None, faces: Faces) -> Patch:
    """Mean cosine of incidence on each facet, of rays from behind nothing."""
    factors = []
    for block in face:
        if direction is None:
            factors.append(np.ones(len(block.dofs)))
            continue
        rays = np.asarray(direction, dtype=float) / np.linalg.norm(direction)
        lit = np.maximum(0.0, -block.normals @ rays)
        factors.append((block.areas * lit).sum(axis=1) / block.areas.sum(axis=1))
    return Patch(_facets(face, faces), np.concatenate([np.empty(0), *factors]))


def _irradiated(
    face: Face, faces: Faces, ends: tuple[Array, Array], times: Array
) -> Sequence[tuple[Patch, Array]]:
    """Mean density on each facet; what is there at the start fades while that of the end rises."""
    rise = times / times[-1]
    facets = _facets(face, faces)
    return [
        (Patch(facets, _means(face, values)), along)
        for values, along in zip(ends, (1.0 - rise, rise), strict=True)
    ]


def _means(face: Face, densities: Array) -> Array:
    """(facets,) [W/m^2] by area, of densities at the points of a face one after the other."""
    means, first = [np.empty(0)], 0
    for block in face:
        last = first + block.areas.size
        here = densities[first:last].reshape(block.areas.shape)
        means.append((block.areas * here).sum(axis=1) / block.areas.sum(axis=1))
        first = last
    return np.concatenate(means)
