"""Heat by CalculiX, an outside opinion: ``CalculixHeat`` (Dhondt 2004).

Bodies are meshed in 3D as by ``thermal.solid``, written as a deck, solved window by window by the
program ``ccx`` and read back. Elements, quadrature, time integration (backward Euler) and Newton's
method are all its own; only nodes and conditions are shared. A conductance from outside is taken
at its mean over a window. What flowed in is evaluated here from
the temperatures at the end of each increment, so that the balance closes to what CalculiX
resolves, not to round-off.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from thermal import calculix_results
from thermal.boundary import Boundary, Moment
from thermal.calculix_deck import (
    HOTTEST,
    STEADY,
    equal_increments,
    initial_text,
    limited_increments,
    model_text,
    steps_text,
    with_factors,
)
from thermal.calculix_loads import Loads, Window
from thermal.calculix_model import assemble, refusals
from thermal.calculix_program import executed, program
from thermal.calculix_solids import elements, solid_space
from thermal.check import check
from thermal.composite import compose
from thermal.description import DEFAULT, Description, Settings
from thermal.discretisation import Discretisation, Face, GivenTemperatures
from thermal.heat import NOTHING, Outside
from thermal.layout import given_nodes
from thermal.limits import Limits, watched
from thermal.lumps import LumpSpace

Array = NDArray[np.float64]

PATIENCE = 3600.0  # [s] with one window, unless a solver has less
SAMPLES = 33  # times at which histories are taken within a window of increments of CalculiX's own
BEND = 100.0  # [K] scale on which a temperature bends: relates change and error of an increment


class CalculixHeat:
    """Temperatures in 3D, and of lumps, by CalculiX.

    Parameters
    ----------
    description : Description
    settings : Settings
        ``steps`` increments of a window are equal; without, CalculiX chooses them such that none
        changes a temperature by more than sqrt(2 tolerance 100 K), whose error of backward Euler
        is the tolerance if the temperature bends on a scale of 100 K. CalculiX always stores heat
        by integrals, but leaves out what couples free to prescribed temperatures; with the capacity
        "consistent", and of order 2, this is given to it as a load

    Attributes
    ----------
    taken : int  increments of the last window
    patience : float [s]  time that CalculiX has for a window
    exact : bool  whether the last temperatures were read in all digits; otherwise 7 were printed
    """

    def __init__(self, description: Description, settings: Settings = DEFAULT) -> None:
        check(description)
        self._program = program()
        _refuse(refusals(description, settings))
        self.settings = settings
        self.space = _space(description, settings)
        self.x, self.regions = self.space.x, self.space.regions
        bodies = elements(description, self.space, settings)
        quadratic = any(e.kind in ("C3D10", "C3D20") for e in bodies)
        self._couples = settings.capacity == "consistent" or quadratic
        assembled = assemble(description, self.space, bodies)
        self._loads = Loads(description, self.space, assembled, self._couples)
        _refuse(self._loads.problems())
        self._boundary = Boundary(description, self.space)
        self._limits, self._watched = Limits(description), watched(description, self.space)
        self.irradiated: Mapping[str, Face] = self._boundary.irradiated
        self._model, self._held = assembled.model, assembled.held
        self._text = model_text(assembled.model)
        self._factors = [e.factor for e in assembled.model.elements if e.factor]
        self._varies = any(
            len(t.temperatures) > 1
            for e in assembled.model.elements
            for t in (e.substance.heat_capacity, *e.substance.conductivities)
        )
        self.taken, self.exact, self.patience = 0, False, PATIENCE

    def initial(self) -> Array:
        """(n,) [K]"""
        return self.space.start.copy()

    def energy(self, T: Array) -> float:
        """Stored heat [J] above the materials' datum of enthalpy."""
        return float(self.space.heat(T).sum())

    def advance(
        self, T: Array, t: float, h: float, heat: Array, outside: Outside = NOTHING
    ) -> tuple[Array, Mapping[str, float], str]:
        """Temperatures at ``t + h``, heat [J] through each boundary, reason; see ThermalSolver."""
        window, procedure = self._window(T, t, h, heat, outside)
        steps, times = self.settings.steps, window.times
        history, why = self._run(window, procedure)
        if why:
            return T.copy(), {}, why
        ends = history.times if steps is None else times[1:]  # these in all digits
        flows = self._flows(t, np.append(ends[:-1], h), history.temperatures, window)
        end = history.temperatures[-1]
        return end, flows, self._unusable(end, t + h)

    def deck(self, T: Array, t: float, h: float) -> str:
        """Text of what is solved from ``T`` (n,) [K] at ``t`` on for ``h`` [s]; see advance.

        Nothing comes from outside.
        """
        return self._deck(*self._window(T, t, h, np.zeros_like(T), NOTHING))

    def steady_deck(self, T: Array, t: float) -> str:
        """Text of what is solved for the steady state under the conditions of ``t`` [s]."""
        return self._deck(_still(T, t, NOTHING), STEADY)

    def _window(
        self, T: Array, t: float, h: float, heat: Array, outside: Outside
    ) -> tuple[Window, Sequence[str]]:
        """A window of time, and how CalculiX is to go through it."""
        steps = self.settings.steps
        if steps is None:
            procedure = limited_increments(h, np.sqrt(2.0 * self.settings.tolerance * BEND))
            times = np.linspace(0.0, h, SAMPLES)
        else:
            procedure, times = equal_increments(h, steps), np.linspace(0.0, h, steps + 1)
        return Window(times, t + times, T, steps is not None, heat / h, outside), procedure

    def steady(
        self, T: Array, t: float, outside: Mapping[str, Array] | None = None
    ) -> tuple[Array, Mapping[str, float], str]:
        """Steady temperatures under the conditions of ``t``, power [W] through each, reason."""
        still = {name: (value, value) for name, value in (outside or {}).items()}
        history, why = self._run(_still(T, t, still), STEADY)
        if why:
            return T.copy(), {}, f"there is no steady state: {why}"
        end = history.temperatures[-1]
        _, flows = self._boundary.power(end, Moment(t, outside or {}))
        named = dict(zip(self._boundary.names, flows.tolist(), strict=True))
        return end, named, self._unusable(end, t)

    def _run(
        self, window: Window, procedure: Sequence[str]
    ) -> tuple[calculix_results.Results, str]:
        """What CalculiX makes of a window, and "" or the reason why it makes nothing."""
        for t in window.moments.tolist():
            if why := self._limits.complaint(t):
                return NO_RESULTS, f"t = {t:g} s: {why}"
        text = self._deck(window, procedure)
        with TemporaryDirectory(prefix="thermobody-ccx-") as folder:
            job = Path(folder) / "heat"
            job.with_suffix(".inp").write_text(text)
            said, code = executed(self._program, job, self.patience)
            try:
                if code:
                    raise ValueError(f"it ended with code {code}")
                found = calculix_results.read(job, len(self._model.x))
                _require_whole(found, float(window.times[-1]))
            except ValueError as error:
                return NO_RESULTS, f"CalculiX: {error}: {calculix_results.message(said)}"
        self.taken, self.exact = len(found.times), found.exact
        return found._replace(temperatures=found.temperatures[:, : len(self.x)]), ""

    def _deck(self, window: Window, procedure: Sequence[str]) -> str:
        amplitudes, loads = self._loads.text(window)
        first = initial_text(self._everywhere(window))
        factors = {n: float(np.mean([end[0] for end in window.outside[n]])) for n in self._factors}
        text = with_factors(self._text, self._model, factors)
        return "\n".join([text, *first, *amplitudes, *steps_text(procedure, loads), ""])

    def _everywhere(self, window: Window) -> Array:
        """Temperatures also of the nodes of lumps and links."""
        whole = np.concatenate([window.T, np.zeros(len(self._model.x) - len(self.x))])
        for held in self._held:
            whole[held.nodes] = held.temperature(float(window.moments[0]))
        for node, mean in self._model.ties:
            whole[node] = mean.weights @ whole[mean.nodes]
        return whole

    def _flows(self, t: float, ends: Array, fields: Array, window: Window) -> dict[str, float]:
        """Heat [J] through each boundary by backward Euler, and what held given temperatures."""
        steps, h = np.diff(ends, prepend=0.0), ends[-1]
        flows = np.zeros(len(self._boundary.names))
        received = window.heat * h
        for field, end, step in zip(fields, ends, steps, strict=True):
            s = end / h
            now = {name: (1.0 - s) * a + s * b for name, (a, b) in window.outside.items()}
            power, through = self._boundary.power(field, Moment(t + float(end), now))
            flows += step * through
            received = received + step * (power + self.space.power(field))
        missing = self.space.heat(fields[-1]) - self.space.heat(window.T) - received
        named = {
            g.name: float(missing[g.nodes].sum()) + self._uncounted(g, window)
            for g in self.space.given
        }
        return named | dict(zip(self._boundary.names, flows.tolist(), strict=True))

    def _uncounted(self, g: GivenTemperatures, window: Window) -> float:
        """Heat [J] that free temperatures store as ``g`` changes, and CalculiX did not count."""
        if self._couples and window.jumps:
            return 0.0
        T = window.T.copy()
        T[g.nodes] = g.at(float(window.moments[0 if self._couples else -1]))
        more = self.space.heat(T) - self.space.heat(window.T)
        more[given_nodes(self.space.given)] = 0.0
        return float(more.sum())

    def _unusable(self, T: Array, t: float) -> str:
        if T.size and T.min() < 0.0:
            return "a temperature fell below 0 K"
        if self._varies and T.max() > HOTTEST:
            return f"a temperature rose over {HOTTEST:g} K, to where tables of properties reach"
        complaints = (w.complaint(T, t) for w in self._watched)
        return self.space.unusable(T) or next(filter(None, complaints), "")


NO_RESULTS = calculix_results.Results(np.empty(0), np.empty((0, 0)), False)


def _still(T: Array, t: float, outside: Outside) -> Window:
    """A window in which nothing changes."""
    return Window(np.array([0.0, 1.0]), np.array([t, t]), T, False, np.zeros_like(T), outside)


def _refuse(problems: Sequence[str]) -> None:
    if problems:
        raise ValueError("\n  ".join(["CalculiX cannot express this:", *problems]))


def _space(d: Description, settings: Settings) -> Discretisation:
    """The same temperatures as of ``thermal.solid``; heat is stored as CalculiX stores it."""
    settings = replace(settings, capacity="consistent")
    lumps = {p.name for p in d.parts}
    bodies = {m.name for m in d.members} | {s.name for s in d.sheets} | {s.name for s in d.solids}
    return compose(d, [(solid_space(settings), bodies), (LumpSpace, lumps)])


def _require_whole(found: calculix_results.Results, h: float) -> None:
    if found.times[-1] < h * (1.0 - 1e-5):
        raise ValueError(f"it stopped after {found.times[-1]:g} s of {h:g} s")
    if not np.isfinite(found.temperatures).all():
        raise ValueError("its temperatures are no numbers")
