"""What runs leave behind, read and compared bit for bit."""

import numpy as np

from coupling.contact_history import MANY
from coupling.results import Results


def consistent(folder):
    """Read everything of a run; tables of one clock have rows of equal number."""
    with Results.open(folder) as results:
        groups = {g: results.table(g) for g in results.groups()}
        state, attributes = results.read_state(), results.attributes()
    for group, table in groups.items():
        assert len({len(column) for column in table.values()}) <= 1, group
        if "time" in table:
            assert np.all(np.diff(table["time"]) > 0), group
    if not state:  # killed before the state at t = 0 was written
        assert not groups
        return groups, state, attributes
    t = state["coupled"]["motion"]["motion"]["t"]
    rows = len(groups["windows"]["time"]) if "windows" in groups else 0
    assert rows == (len(groups["ledger"]["kinetic"]) if rows else 0)
    if rows:
        assert groups["windows"]["time"][-1] == t
    for group, table in groups.items():
        if group.startswith("probes/"):
            assert len(table["time"]) == rows + 1 and table["time"][-1] == t
        if group.startswith("joints/") and table:
            taken = groups["windows"]["steps"].sum()
            some = len([name for name in groups if name.startswith("joints/")]) > MANY
            assert len(table["time"]) <= taken if some else len(table["time"]) == taken
            assert not rows or table["time"][-1] == t
        if group.startswith("bodies/"):
            assert len(table["position"]) == len(groups["frames"]["time"])
    return groups, state, attributes


def assert_same(a, b, where=""):
    """Equal bit for bit, through nested records; clocks on the wall may differ."""
    if isinstance(a, dict):
        assert a.keys() == b.keys(), where
        for key in a:
            if key != "wall_time":
                assert_same(a[key], b[key], f"{where}/{key}")
    else:
        a, b = np.asarray(a), np.asarray(b)
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), where


def assert_same_results(a, b):
    (ours, state, _), (theirs, expected, _) = consistent(a.folder), consistent(b.folder)
    assert_same(state, expected)
    assert_same(ours, theirs)
