"""Figs. 19 to 21: the ring truss that deploys, its corners in the cold, a hinge of it.

The paper gives no mechanism and no members; ``cases/reflector`` has a perimeter truss (Thomson
2000) of its diameter, clearances and shock.
"""

from collections.abc import Iterator
from csv import DictReader

import numpy as np

from coupling.deployment_pictures import diameters, liveliest_hinge, ring_of
from coupling.paper.entries import Entry, number
from coupling.paper.workshop import Recorded, Workshop
from coupling.reading import Results
from coupling.reports.timed_runs import Ran

CASE = "reflector"
STILL = {
    "analysis.kind": "statics", "analysis.steps": 4, "generate.ring.shock.duration": "0.5 s",
    "time.end": "0.5 s", "output.export": [],
}  # fmt: skip
"""Equilibria of the latched ring on its way from the first to the last temperature."""
PLACES = ("far", "radial_cold", "radial_warm", "chord_cold", "chord_warm")


def entries(work: Workshop) -> Iterator[Entry]:
    """Deployment, thermal displacement, motion of a hinge."""
    printed = _printed(work)
    yield _deployment(work, printed)
    yield _displacement(work, printed)
    yield _hinge(work, printed)


def _printed(work: Workshop) -> dict[str, float]:
    file = work.cases / CASE / "reference" / "figures.csv"
    lines = [x for x in file.read_text(encoding="utf-8").splitlines() if not x.startswith("#")]
    return {row["quantity"]: float(row["value"]) for row in DictReader(lines)}


def _done(run: Recorded) -> Recorded:
    if run.code:
        raise RuntimeError(f"{CASE}: {run.reason}")
    return run


def _deployment(work: Workshop, printed: dict[str, float]) -> Entry:
    play = "with play in all hinges and sliders" if work.large else "without play"
    run = _done(work.recorded(CASE, ("whole", "tight" if work.large else "ideal")))
    with Results.open(run.folder) as results:
        ring = ring_of(results)
        assert ring is not None
        width = diameters(ring)
    open_to, full = 100.0 * width[0] / width.max(), printed["diameter"]
    first, last = printed["first expansion ratio"], printed["last expansion ratio"]
    return Entry(
        "Fig. 19",
        "ring truss deploys through its own joints, latches, is cooled, in one model",
        f"{first:g} to {last:g} % of {full:g} m, star-like, then polygonal, then round",
        "no mechanism is given, and 0.01 rad/s^2 does not go with 6000 s (Table 4)",
        f"36 panels that shear: {number(open_to, '%')} to {number(width.max(), 'm')} by one rope, "
        f"{play}; {number(run.seconds, 's', 3)} of computing with the shock",
        "not determined by the paper: with panels that shear the ring is a regular polygon at "
        "every stage, not star-like",
        (7, 9, 11, 12, 13, 14, 65),
        (work.picture(run.picture("deployment"), "reflector_deployment"),),
    )


def _displacement(work: Workshop, printed: dict[str, float]) -> Entry:
    whole = _equilibrium(work, ("ideal", "uniform"))
    half = _equilibrium(work, ("ideal",))
    radial = 0.5 * whole["far"]
    said = printed["largest thermal displacement"]
    return Entry(
        "Fig. 20",
        "displacement of nodes from hot to cold [m]",
        f"at most {said:g} m, more when hot; radial nodes in the plane, chord nodes out of it",
        f"250 K everywhere: {number(radial, 'm')} radially, {number(whole['far'], 'm')} opposite "
        f"to where the ring is held; one half cooled: {number(max(half.values()), 'm')}",
        f"radial node {number(half['radial_cold'], 'm')} in the cold half and "
        f"{number(half['radial_warm'], 'm')} in the warm one, chord node "
        f"{number(half['chord_cold'], 'm')} and {number(half['chord_warm'], 'm')}",
        f"does not follow from the inputs: {said:g} m is {number(said / radial, '', 3)} times the "
        "radial shrinkage by 250 K; it would take a gradient that the paper does not give",
        (37, 44, 65),
    )


def _equilibrium(work: Workshop, variants: tuple[str, ...]) -> dict[str, float]:
    """Displacements [m] of the probes at the end of the shock, at rest."""
    sought = {place: f"probe.{place}.position" for place in PLACES}
    ran: Ran = work.run(CASE, variants, STILL, sought)
    if ran.outcome != "done":
        raise RuntimeError(f"{CASE}: {ran.reason}")
    found = {
        name: np.asarray(rows).reshape(len(ran.times), -1) for name, rows in ran.values.items()
    }
    return {name: float(np.linalg.norm(rows[-1] - rows[0])) for name, rows in found.items()}


def _hinge(work: Workshop, printed: dict[str, float]) -> Entry:
    run = _done(work.recorded(CASE, ("shock",) if work.large else ()))
    with Results.open(run.folder) as results:
        hinge = liveliest_hinge(results)
    rate = np.gradient(hinge.angle, hinge.time)
    turned = number(1e3 * float(np.ptp(hinge.angle)), "mrad", 3)
    fastest = number(1e3 * float(np.abs(rate).max()), "mrad/s", 3)
    begin, end = printed["first angular displacement"], printed["last angular displacement"]
    return Entry(
        "Fig. 21",
        "turn of a hinge with play during the shock [mrad], and its phase portrait",
        f"drifts from {begin:g} to {end:g} mrad with fast ripples; scattered loops",
        "neither the hinge nor the time is given",
        f"{hinge.name}, the one that turns most: {turned} in the first "
        f"{number(float(hinge.time[-1]), 's', 3)} of the shock, at up to {fastest}, with "
        f"{hinge.changes.size} changes between flight, stick and slip",
        "trend reproduced: a drift with ripples by impacts; the numbers are not determined",
        (17, 19, 25, 65),
        (work.picture(run.picture("hinge"), "reflector_hinge"),
         work.picture(run.picture("paths"), "reflector_paths")),
    )  # fmt: skip
