"""Figs. 14 to 18 and sections 4.2.1 and 4.2.2: the arm that is pushed out, the arm that turns."""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np

from coupling.paper.entries import Entry
from coupling.paper.workshop import Workshop
from coupling.reading import Results
from coupling.telescope_pictures import Standing, draw_snapshot, draw_surfaces, standing, surfaces
from coupling.turning_pictures import Course, Stage, course, draw_stages, draw_stick_slip, stage

SHOTS = ((620.46, 54.2, 1.2, 998, 180.0), (715.65, 63.5, 0.5, 798, 184.0))
"""Figs. 15 and 14: time [s], stroke [m], offset [m], contacts, temperature [degC]."""
STAGES = (
    (0.0, 0.0, "stick"),
    (28.49, 7.9, "slip"),
    (416.43, 41.0, "slip"),
    (611.69, 45.4, "stick"),
)
"""Fig. 17: time [s], angle [deg], state."""
SLIPPING = 0.45, 0.28
"""Fig. 16: share of slip on both surfaces."""
AMPLITUDE = 0.95e-3
"""Fig. 18 [m]."""
WINDOW = 15.0
"""Of Fig. 16 [s]."""


def entries(work: Workshop) -> Iterator[Entry]:
    """The shock, then the deployments if they are wanted."""
    yield _slip(work)
    if work.large:
        yield from _strokes(work)
    yield _friction(work)
    yield _stages(work)


def _slip(work: Workshop) -> Entry:
    own, paper = (work.recorded("arm_extension", v) for v in ((), ("hua2026",)))
    shares = []
    for ran in (own, paper):
        with Results.open(ran.folder) as results:
            shares.append(surfaces(results, "sleeve", WINDOW).slipping())
    return Entry(
        "Fig. 16",
        "share of slip in the contact of both surfaces, 0 to 15 s",
        f"{100 * SLIPPING[0]:.0f} % on the arm, {100 * SLIPPING[1]:.0f} % in the boom",
        f"{100 * shares[1]:.0f} % on both",
        f"{100 * shares[0]:.0f} % on both: surfaces that touch do so at the same places and times",
        "does not follow: the two shares cannot differ; how unevenly the tubes warm is not given",
        (19, 29, 63),
        (
            _drawn(
                work, own.folder, "figure_16", (12.0, 8.0), partial(draw_surfaces, joint="sleeve")
            ),
        ),
    )


def _strokes(work: Workshop) -> Iterator[Entry]:
    for figure, variants, shot in (
        ("Fig. 14", ("whole", "preloaded"), SHOTS[1]),
        ("Fig. 15", ("whole",), SHOTS[0]),
    ):
        ran = work.recorded("arm_extension", variants)
        with Results.open(ran.folder) as results:
            found = standing(results, "sleeve", shot[0])
        draw = partial(draw_snapshot, joint="sleeve", time=shot[0])
        name = figure.lower().replace(". ", "ure_")
        picture = _drawn(work, ran.folder, name, (14.0, 7.5), draw)
        yield _shot(figure, shot, found, variants, picture)


def _shot(
    figure: str, shot: tuple[float, ...], found: Standing, variants: tuple[str, ...], picture: Path
) -> Entry:
    time, stroke, offset, contacts, temperature = shot
    return Entry(
        figure,
        f"the arm at {time:g} s, {'with' if 'preloaded' in variants else 'without'} preload",
        f"stroke {stroke:g} m, offset {offset:g} m, {contacts:g} contacts, {temperature:g} degC",
        "0.1 m/s from the start would make "
        f"{0.1 * time:.1f} m; a load that ends at 50 degC cannot make {temperature:g} degC",
        f"stroke {found.travel:.2f} m, {found.offset:.2f} m off the axis, "
        f"{int(found.counts[1:].sum())} stations touch, {found.temperature - 273.15:.1f} degC, "
        f"{found.state}",
        "not determined: contacts count a mesh that is not given, offsets depend on heating that "
        "is not given; the stroke follows from a dwell of 78.5 s",
        (11, 16, 19, 63) if "preloaded" in variants else (11, 19, 63),
        (picture,),
    )


def _friction(work: Workshop) -> Entry:
    own, paper = (work.recorded("arm_rotation", v) for v in (("stick",), ("hua2026",)))
    found = [_course(ran.folder) for ran in (own, paper)]
    said = [
        f"{len(c.transitions())} transitions in {c.time[-1]:.0f} s, journal "
        f"{1e6 * float(np.ptp(c.across)) / 2:.0f} um to both sides, clearance changed by "
        f"{1e6 * float(np.abs(c.opened).max()):.2g} um"
        for c in found
    ]
    return Entry(
        "Fig. 18",
        "thermal deformation of the contact surface, stick and slip",
        f"amplitude {1e3 * AMPLITUDE:g} mm; frequent transitions after 6 s, at both limits",
        said[1],
        said[0] + "; transitions gather where the journal comes to a limit",
        "does not follow: the amplitude is 19 times the clearance of 0.05 mm; transitions at both "
        "limits are found",
        (14, 29, 64),
        (
            _drawn(
                work, own.folder, "figure_18", (11.0, 7.0), partial(draw_stick_slip, joint="hinge")
            ),
        ),
    )


def _course(folder: Path) -> Course:
    with Results.open(folder) as results:
        return course(results, "hinge")


def _stages(work: Workshop) -> Entry:
    ran = work.recorded("arm_rotation", ("whole", "stick"))
    with Results.open(ran.folder) as results:
        found = [stage(results, "hinge", time) for time, _, _ in STAGES]
    times = tuple(time for time, _, _ in STAGES)
    draw = partial(draw_stages, joint="hinge", times=times)
    rates = np.diff([angle for _, angle, _ in STAGES]) / np.diff(times)
    return Entry(
        "Fig. 17",
        "angle [deg] and state at 0, 28.49, 416.43 and 611.69 s",
        ", ".join(f"{angle:g} {state}" for _, angle, state in STAGES) + ", locked",
        "mean rates between the printed angles: "
        + ", ".join(f"{rate:.3f}" for rate in rates)
        + " deg/s, for a turn at constant speed",
        ", ".join(_said(one) for one in found),
        "does not follow: the printed angles are of no constant speed; the turn ends locked and "
        "sticking",
        (14, 15, 64),
        (_drawn(work, ran.folder, "figure_17", (14.0, 5.0), draw),),
    )


def _said(one: Stage) -> str:
    return f"{np.degrees(one.angle):.1f} {one.state} {one.latch}".strip()


def _drawn(
    work: Workshop,
    run: Path,
    name: str,
    size: tuple[float, float],
    draw: Callable[..., None],
) -> Path:
    """A picture of a run in the folder of the report."""
    import matplotlib
    from matplotlib.figure import Figure

    from coupling.plot import STYLE

    work.folder.mkdir(parents=True, exist_ok=True)
    path = work.folder / f"{name}.png"
    with matplotlib.rc_context(STYLE), Results.open(run) as results:
        figure: Figure = Figure(figsize=size, dpi=100, layout="constrained")
        draw(results, figure)
        figure.savefig(path)
    return path
