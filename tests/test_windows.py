"""Windows that adapt, and [coupling] in the case file."""

import json
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from coupled_pairs import exact, pair, resistance

from coupling import casefile
from coupling.errors import BadCase
from coupling.iteration import Iterated
from coupling.manager import corrected, initial
from coupling.model import build
from coupling.overrides import parse
from coupling.pace import Coefficients, Pace
from coupling.reading import Results
from coupling.simulation import TICKS, Stopped, run, windows
from coupling.verify.thermoelastic_heat import WARM

CASE = (
    WARM.replace('end = "2 s"', 'end = "0.8 s"')
    + """
[thermal.source.lamp]
at = { part = "pin" }
power = { step = { at = 0.35, from = 0.0, to = 2000.0 } }
"""
)
ADAPTIVE = """
[coupling.adaptive]
change = 0.004
tolerance = 0.005
"""


def scene(text="", *settings, case=CASE):
    return casefile.from_text(case + text, Path(), parse(settings))


def done(model, state=None, **start):
    found = list(windows(model, state or model.initial(), **start))
    assert not isinstance(found[-1], Stopped), found[-1]
    return found


def same(a, b):
    """Equal bit for bit, through nested records."""
    if isinstance(a, tuple):
        return len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    return np.array_equal(a, b)


# ----------------------------------------------------------------------------------- the measure


@pytest.fixture(scope="module")
def model():
    return build(scene(ADAPTIVE))


def test_coefficients_of_equal_temperatures_are_not_apart(model):
    T = model.initial().T
    assert model.pace.coefficients.apart(T, T) == 0.0


def test_the_measure_is_that_of_the_coefficient_that_changes_most(model):
    """The clearance of 50 um, when only the pin gets warmer: alpha R dT of it."""
    system, T = model.motion_solver.system, model.initial().T
    warm = T.copy()
    warm[model.pair.heat_solver.regions["hinge.journal"]] += 1.0
    read = model.pair.transfer.read
    c0, c1 = (system.coefficients(read(x)) for x in (T, warm))
    changes = [
        np.abs(b - a).max() / np.abs(a).max()
        for a, b in ((x[:, j], y[:, j]) for x, y in zip(c0, c1, strict=True)
                     for j in range(x.shape[1]))
        if np.any(a != b)
    ]  # fmt: skip
    found = model.pace.coefficients.apart(T, warm)
    assert found == pytest.approx(max(changes), rel=1e-12)
    expansion = model.scene.joint["hinge"].radius * 2.3e-5 / model.scene.joint["hinge"].clearance
    assert found == pytest.approx(expansion, rel=0.3)


def test_the_measure_does_not_depend_on_units(model):
    """Free strains from zero are measured by the absolute temperature: 3 K of 300 K, 1 %."""
    T = model.initial().T
    arm = T.copy()
    arm[model.pair.heat_solver.regions["arm"]] += 3.0
    assert model.pace.coefficients.apart(T, arm) == pytest.approx(0.01, rel=0.05)


# ------------------------------------------------------------------------------------ the windows


@pytest.fixture(scope="module")
def adapted(model):
    return done(model)


def test_windows_lie_on_the_ladder_and_end_where_the_run_does(adapted, model):
    sizes = np.array([w.size for w in adapted])
    starts = np.array([w.tick for w in adapted]) - sizes
    assert np.all(starts % sizes == 0) and np.all(TICKS % sizes == 0)
    assert adapted[-1].tick == model.windows * TICKS and adapted[-1].t == model.end


def test_windows_become_short_where_the_lamp_is_lit(adapted):
    h = {round(w.t - w.h, 9): w.h for w in adapted}
    assert h[0.0] == 0.1 / 64 and h[0.2] == pytest.approx(0.1)
    assert max(h[t] for t in h if t >= 0.35) <= 0.1 / 8 + 1e-12
    assert max(w.halvings for w in adapted) == 2


def test_every_window_keeps_the_limits(adapted, model):
    states = [model.initial(), *(w.state for w in adapted)]
    apart = model.pace.coefficients.apart
    for before, after in pairwise(states):
        assert apart(before.T, after.T) <= 0.004
    for after in states[2:]:
        assert apart(after.T, after.exchange.expected) <= 0.005


class Drag:
    """The coefficient of ``coupled_pairs``."""

    def apart(self, T0, T1):
        return abs(resistance(T1[0]) / resistance(T0[0]) - 1.0)


def dragged(scheme, tolerance):
    """Windows of a pair with an exact solution, and the error of its end."""
    solvers = pair()
    made = SimpleNamespace(
        advance=scheme, pace=Pace(Drag(), 0.5, tolerance, 8), pair=solvers,
        window=0.5, windows=4, smallest_window=0.0,
    )  # fmt: skip
    found = done(made, initial(solvers))
    end = found[-1].state
    return found, float(np.abs(np.array([end.motion.v, end.T[0]]) - exact()).max())


@pytest.mark.parametrize("scheme", [corrected, Iterated(1e-8, 1e-8)])
def test_tighter_limits_make_more_windows_and_a_smaller_error(scheme):
    """Errors of a window fall with its square, and so do windows with the root of the limit."""
    counts, errors = [], []
    for tolerance in (1e-2, 1e-3, 1e-4):
        found, error = dragged(scheme, tolerance)
        counts.append(len(found))
        errors.append(error)
    assert counts[0] < counts[1] < counts[2]
    assert errors[1] < 0.6 * errors[0] and errors[2] < 0.6 * errors[1]
    assert errors[2] < 0.02


def test_windows_grow_again_once_temperatures_settle():
    """Drag falls fast at first, and slowly later."""
    found, _ = dragged(corrected, 1e-3)
    sizes = [w.size for w in found]
    assert min(sizes) < max(sizes[sizes.index(min(sizes)) :])
    assert any(a < b for a, b in pairwise(sizes)) and any(w.halvings for w in found)


def test_going_on_from_any_window_gives_the_same_windows(adapted, model):
    for k in (0, 3, len(adapted) // 2, len(adapted) - 2):
        w = adapted[k]
        rest = done(model, w.state, tick=w.tick, size=w.size)
        assert same(tuple(rest), tuple(adapted[k + 1 :]))


def test_a_refused_window_leaves_nothing_behind(model, adapted):
    """Its state, contact history included, is what it was: shorter windows give the same bits."""
    k = next(i for i, w in enumerate(adapted) if w.halvings)
    before = adapted[k - 1].state
    refused, why = model.advance(model.pair, before, adapted[k - 1].t, 2.0 * adapted[k].h, None)
    assert why == "" and model.pace.judged(before, refused)[1] != ""
    again, _ = model.advance(model.pair, before, adapted[k - 1].t, adapted[k].h, None)
    assert same(model.pace.judged(before, again)[0], adapted[k].state)
    fresh = build(scene(ADAPTIVE))
    alone, _ = fresh.advance(fresh.pair, before, adapted[k - 1].t, adapted[k].h, None)
    assert same(alone.motion, adapted[k].state.motion) and np.array_equal(alone.T, again.T)


def test_a_limit_that_cannot_be_kept_stops_the_run_with_the_reason():
    settings = "coupling.smallest_window=0.05", "coupling.adaptive.change=0.004"
    model = build(scene(ADAPTIVE, *settings))
    found = list(windows(model, model.initial()))
    assert isinstance(found[-1], Stopped)
    assert "temperature-dependent coefficients" in found[-1].why and "limit is" in found[-1].why
    assert found[-1].t < 0.4


def test_windows_without_the_table_are_of_one_length(model):
    fixed = build(scene())
    assert fixed.pace is None
    assert {w.size for w in done(fixed)} == {TICKS}


def test_iterations_make_windows_shorter():
    """What takes more than are wanted is followed by a shorter window, and not refused."""
    wanted = Pace(Coefficients.__new__(Coefficients), 1.0, 1.0, 4)
    assert wanted._growth(0.0, 0.0, 5) == -1
    assert wanted._growth(0.0, 0.0, 4) == 0
    assert wanted._growth(0.0, 0.0, 2) == 1
    assert wanted._growth(0.6, 0.0, 1) == wanted._growth(0.0, 0.3, 1) == 0


def test_a_window_after_many_iterations_is_shorter():
    calls = []

    def slow(solvers, state, t, h, observe):
        calls.append(h)
        new, why = corrected(solvers, state, t, h, observe)
        return new._replace(exchange=new.exchange._replace(iterations=9 - len(calls))), why

    made = SimpleNamespace(
        advance=slow, pace=Pace(Drag(), 1.0, 1.0, 7, first=0), pair=pair(),
        window=0.5, windows=2, smallest_window=0.0,
    )  # fmt: skip
    done(made, initial(made.pair))
    assert calls[:3] == [0.5, 0.25, 0.25]


# ---------------------------------------------------------------------------------- runs resumed


@pytest.mark.parametrize(
    "settings", [[], ["coupling.scheme='iterated'", "coupling.heat_tolerance=1e-8"]]
)
def test_adaptive_runs_go_on_bit_for_bit(tmp_path, settings):
    more = ["time.end='0.6 s'", *settings]
    whole = run(scene(ADAPTIVE, *more), tmp_path / "whole")
    run(scene(ADAPTIVE, "time.end='0.4 s'", *settings), tmp_path / "halves")
    resumed = run(scene(ADAPTIVE, *more), tmp_path / "halves", resume=True)
    with Results.open(whole.folder) as a, Results.open(resumed.folder) as b:
        np.testing.assert_equal(b.read_state(), a.read_state())
        rows = a.table("windows"), b.table("windows")
    for name, column in rows[0].items():
        if name != "wall_time":
            np.testing.assert_array_equal(rows[1][name], column, name)
    assert rows[0]["halvings"].max() > 0 and rows[0]["exchanges"].min() >= 1
    assert rows[0]["window_error"].max() > 0.0


# ----------------------------------------------------------------------------------- the case file


@pytest.mark.parametrize(
    ("settings", "path"),
    [
        (["coupling.acceleration='aitken'"], "coupling.acceleration"),
        (["coupling.scheme='serial'", "coupling.most_iterations=9"], "coupling.most_iterations"),
        (["coupling.adaptive.iterations=9"], "coupling.adaptive.iterations"),
        (
            ["coupling.scheme='iterated'", "coupling.acceleration='none'",
             "coupling.relaxation=0.5"],
            "coupling.relaxation",
        ),
        (
            ["coupling.scheme='iterated'", "coupling.acceleration='aitken'",
             "coupling.reused_windows=3"],
            "coupling.reused_windows",
        ),
        (
            ["coupling.scheme='parallel'", "coupling.adaptive.change=0.1"],
            "coupling.adaptive",
        ),
        (["coupling.scheme='iterate'"], "coupling.scheme"),
        (["coupling.adaptive.change=0"], "coupling.adaptive.change"),
        (["coupling.adaptive.chance=0.1"], "coupling.adaptive.chance"),
    ],
)  # fmt: skip
def test_keys_that_do_not_fit_are_refused(settings, path):
    with pytest.raises(BadCase) as refusal:
        scene("", *settings)
    assert [p.path for p in refusal.value.problems] == [path]


def test_settings_reach_the_iteration():
    text = """
[coupling]
scheme = "iterated"
acceleration = "relaxation"
temperature_tolerance = 1e-6
heat_tolerance = 1e-5
most_iterations = 7
"""
    made = build(scene(text))
    assert (made.advance.acceleration, made.advance.factor, made.advance.most) == (
        "relaxation", 0.5, 7,
    )  # fmt: skip
    assert (made.advance.temperature_tolerance, made.advance.heat_tolerance) == (1e-6, 1e-5)
    assert "coupling.iterated" in made.plan and "relaxation iteration" in made.plan
    assert "windows of up to 0.1 s" in build(scene(ADAPTIVE)).plan
    json.dumps(made.meta(made.scene))
