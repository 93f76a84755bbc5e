"""Histories of contacts: onsets, releases, totals and kept rows, from made-up steps."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

from coupling.contact_history import (
    KEPT,
    MANY,
    ONSET,
    RELEASE,
    Steps,
    events,
    kept_rows,
    most_rows,
    summary,
)
from coupling.contacts import BALL, END, PLANAR, TUBE, WALL, Contact, history, regimes
from mechanics import march

RNG = np.random.default_rng(0)


def steps_of(times, depth, rate, approach, **columns):
    """Steps of contacts with the given depths (k, n_c) and other columns by their place."""
    response = np.zeros((*np.shape(depth), march.COLUMNS))
    response[..., march.DEPTH], response[..., march.DEPTH_RATE] = depth, rate
    for name, values in columns.items():
        response[..., getattr(march, name)] = values
    return Steps(np.asarray(times, float), response, np.asarray(approach, float))


def test_a_release_is_where_a_parabola_passes_zero():
    """Depth v t - g t²/2 begins at 0.1 with v = 3 and ends 2 v/g later, with the speed v."""
    v, g, begin = 3.0, 40.0, 0.1
    times = np.array([0.0, begin, 0.17, 0.21, 0.3])
    t = times - begin
    depth, rate = v * t - 0.5 * g * t**2, v - g * t
    running = np.array([0.0, v, v, v, 0.0])
    found = events(steps_of(times, depth[:, None], rate[:, None], running[:, None]))
    assert found.kind.tolist() == [ONSET, RELEASE]
    assert_allclose(found.time, [begin, begin + 2 * v / g], rtol=1e-14)
    assert_allclose(found.speed, [v, v], rtol=1e-13)
    assert found.contact.tolist() == [0, 0] and found.row.tolist() == [0, 3]


def test_an_onset_inside_a_step_is_where_the_parabola_passes_zero():
    """Depth v (t - 0.13), which a short step contains; the speed is that of approach."""
    times, v = np.array([0.1, 0.2]), 3.0
    depth, rate = v * (times - 0.13), np.full(2, v)
    found = events(steps_of(times, depth[:, None], rate[:, None], [[0.0], [v]]))
    assert_allclose(found.time, [0.13], rtol=1e-14)
    assert found.kind.tolist() == [ONSET] and found.speed.tolist() == [v]


def test_a_release_of_a_cubic_depth_is_exact():
    s = np.array([0.0, 1.0])
    depth = (1.0 - 1.4 * s) * (1.0 + s) ** 2 * 1e-6
    rate = (-1.4 * (1.0 + s) ** 2 + 2.0 * (1.0 - 1.4 * s) * (1.0 + s)) * 1e-6
    found = events(steps_of([5.0, 6.0], depth[:, None], rate[:, None], [[1.0], [0.0]]))
    assert_allclose(found.time, 5.0 + 1.0 / 1.4, rtol=1e-14)
    assert_allclose(found.speed, 1.4 * (1.0 + 1.0 / 1.4) ** 2 * 1e-6, rtol=1e-9)


def test_events_of_several_contacts_are_in_the_order_of_time():
    """The second begins before the first, which has run since before the window and ends last."""
    running = [[1.0, 0.0], [1.0, 2.0], [1.0, 0.0], [0.0, 0.0]]
    depth = np.array([[1.0, -1.0], [1.0, 0.0], [1.0, -1.0], [-1.0, -2.0]])
    found = events(steps_of([0.0, 1.0, 2.0, 3.0], depth, np.zeros((4, 2)), running))
    assert found.contact.tolist() == [1, 1, 0]
    assert found.kind.tolist() == [ONSET, RELEASE, RELEASE]
    assert_allclose(found.time, [1.0, 1.0, 2.5])


def test_an_approach_that_is_not_known_counts_with_no_speed():
    found = events(steps_of([0.0, 1.0], [[0.0], [1.0]], [[0.0], [0.0]], [[0.0], [-1.0]]))
    assert found.kind.tolist() == [ONSET] and found.speed.tolist() == [0.0]


def test_totals_of_a_window():
    """Losses are as the integrator found them; regimes share the time."""
    times = np.concatenate([[0.0], np.linspace(0.0, 2.0, 41)[1:]])
    steps = steps_of(
        times, np.ones((41, 1)), np.zeros((41, 1)), np.ones((41, 1)), ELASTIC=times[:, None]
    )
    regime = np.where(times[1:, None] <= 0.5, 3, 2).astype(np.int8)
    totals = summary(steps, regime, events(steps), np.array([[3.0, 12.0]]))
    assert totals["friction_work"].tolist() == [12.0] and totals["hysteresis"].tolist() == [3.0]
    assert_allclose(totals["shares"], [[0.0, 0.0, 0.75, 0.25]], rtol=1e-12)
    assert totals["peak_force"].tolist() == [2.0] and totals["impacts"].tolist() == [0]


def test_few_contacts_keep_every_step_and_many_a_bounded_number():
    assert most_rows(MANY, 10**6) is None
    assert most_rows(144, 1000) == KEPT // 144_000
    assert most_rows(10_000, 10_000) == 1


def test_kept_rows_are_those_of_the_largest_forces_and_all_events():
    count, contacts, most = 97, 3, 5
    force = RNG.random((count + 1, contacts))
    running = np.ones((count + 1, contacts))
    running[40, 1] = 0.0  # a release and an onset
    steps = steps_of(np.arange(count + 1), force, force, running, ELASTIC=force)
    kept = kept_rows(steps, events(steps), most)
    edges = np.arange(most + 1) * count // most
    for j, rows in enumerate(kept):
        assert np.all(np.diff(rows) > 0)
        for a, b in pairwise(edges):
            assert a + np.argmax(force[1 + a : 1 + b, j]) in rows
        assert len(rows) <= most + (2 if j == 1 else 0)
    assert {39, 40} <= set(kept[1].tolist())
    assert all(len(rows) == count for rows in kept_rows(steps, events(steps), None))


# ------------------------------------------------------------------------------ histories


def contact(form, law=None, **friction):
    from coupling.contact_tables import ClearanceRevolute

    table = {"kind": "clearance_revolute", "journal": {"body": "a", "at": "end"}}
    table |= {"axis": [0, 0, 1], "radius": 0.01, "clearance": 1e-4}
    table |= {"journal_material": "al6061", "bearing_material": "al6061"}
    if law is not None:
        table["friction"] = {"coefficient": 0.1, "law": law, **friction}
    made = ClearanceRevolute.model_validate(table)
    nothing = np.zeros(3)
    return Contact("pin", "pin", "", made, form, np.eye(3), nothing, nothing, None, -1)


def test_friction_of_a_planar_pin_has_a_sign_counter_clockwise():
    response = np.zeros((2, march.COLUMNS))
    response[:, march.PATH : march.PATH + 2] = [[0.0, 2e-4], [-1e-4, 0.0]]
    response[:, march.FRICTION : march.FRICTION + 2] = [[-3.0, 0.0], [0.0, 4.0]]
    response[:, march.SLIP : march.SLIP + 2] = [[0.5, 0.0], [0.0, 0.25]]
    times, nothing = np.array([0.0, 1.0]), np.zeros(2)
    rows = history(contact(PLANAR), times, response, nothing, nothing.astype(np.int8))
    assert_allclose(rows["friction_force"], [3.0, -4.0])
    assert_allclose(rows["slip_speed"], [-0.5, -0.25])
    assert rows["orbit"].shape == (2, 2) and "friction_vector" not in rows


@pytest.mark.parametrize(
    ("form", "columns"),
    [(END, {"orbit": (4, 2), "place": (4,)}), (BALL, {"orbit": (4, 3)}),
     (TUBE, {"orbit": (4, 3), "place": (4,)}), (WALL, {"towards_wall": (4,), "place": (4,)})],
)  # fmt: skip
def test_contacts_in_space_have_vectors_and_their_sizes(form, columns):
    response = RNG.random((4, march.COLUMNS))
    times, nothing = np.arange(4.0), np.zeros(4)
    rows = history(contact(form), times, response, nothing, nothing.astype(np.int8))
    assert {name: rows[name].shape for name in columns} == columns
    assert ("orbit" in rows) != ("towards_wall" in rows)
    assert_allclose(rows["friction_force"], np.linalg.norm(rows["friction_vector"], axis=1))
    force = response[:, march.ELASTIC] + response[:, march.DISSIPATIVE]
    assert_allclose(rows["normal_force"], force)


def test_regimes_ask_each_law_in_its_own_way():
    """Slow creep is stick to a regularised law; one with bristles says itself whether it sticks."""
    contacts = [contact(PLANAR, "regularised"), contact(PLANAR, "stick"), contact(PLANAR)]
    response = np.zeros((2, 3, march.COLUMNS))
    response[..., march.DEPTH], response[..., march.SLIP] = 1e-6, 1e-6
    response[1, :, march.STUCK] = 1.0
    found = regimes(contacts, response, np.ones((2, 3)))
    assert found.tolist() == [[3, 2, 2], [3, 3, 2]]
