"""Pictures of a run, in the folder ``pictures`` next to its results."""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from coupling import (
    contact_maps,
    contact_pictures,
    deployment_pictures,
    light_pictures,
    pictures,
    skin_pictures,
    telescope_pictures,
    turning_pictures,
)
from coupling.clocks import analysis_of
from coupling.contact_places import TUBE, contact_groups, form_of, peak_force
from coupling.overview import draw_overview
from coupling.reading import BadResults, Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FOLDER = "pictures"
MOST_JOINTS = 6
FEW_CONTACTS = 8
"""Contacts of a joint up to which each has a line of its own."""
STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 11,
    "axes.titlesize": 12,
    "axes.titlelocation": "left",
    "axes.labelsize": 11,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.xmargin": 0.01,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e7eb",
    "grid.linewidth": 0.8,
    "axes.edgecolor": "#5b6570",
    "axes.prop_cycle": "cycler('color', ['#0072B2', '#D55E00', '#009E73', '#CC79A7', "
    "'#E69F00', '#56B4E9', '#000000', '#8c6d31'])",
    "xtick.color": "#3c444d",
    "ytick.color": "#3c444d",
    "legend.frameon": False,
    "legend.fontsize": 10,
    "lines.linewidth": 1.5,
    "agg.path.chunksize": 20_000,
}


class Picture(NamedTuple):
    """A file name, the function that draws it, and the size of the figure [inch]."""

    name: str
    draw: Callable[[Results, "Figure"], None]
    size: tuple[float, float]


def plot(results_path: Path | str) -> list[Path]:
    """Draw what the results have data for, and return the files."""
    import matplotlib

    with Results.open(results_path) as results:
        found = list(_pictures(results))
        if not found:
            raise BadResults(f"{results.path}: nothing was recorded that can be drawn")
        folder = results.path.parent / FOLDER
        folder.mkdir(exist_ok=True)
        with matplotlib.rc_context(STYLE):
            return [_save(results, picture, folder) for picture in found]


def _save(results: Results, picture: Picture, folder: Path) -> Path:
    from matplotlib.figure import Figure

    figure = Figure(figsize=picture.size, dpi=150, layout="constrained")
    picture.draw(results, figure)
    path = folder / f"{picture.name}.png"
    figure.savefig(path)
    return path


def _pictures(results: Results) -> Iterator[Picture]:
    """The pictures that the recorded data allow."""
    if _rows(results, "frames/time"):
        yield Picture("overview", draw_overview, (12.8, 7.2))
    bodies, kind = pictures.heated_bodies(results), analysis_of(results)
    if _runs_forward(results) and bodies and kind != "modes":
        yield Picture("temperature", pictures.draw_temperature, (11.0, 1.2 + 3.6 * len(bodies)))
    yield from _light_pictures(results)
    probes = pictures.moving_probes(results)
    if kind == "statics" and probes:
        yield Picture("path", pictures.draw_path, (1.5 + 5.0 * len(probes), 5.5))
    if kind == "dynamics" and _rows(results, "windows/time") > 1 and probes:
        rows = pictures.motion_rows(results)
        yield Picture("motion", pictures.draw_motion, (9.0, 1.2 + 2.2 * rows))
    jolted = pictures.accelerated_probes(results) if contact_groups(results) else []
    if _rows(results, "windows/time") > 1 and jolted:
        yield Picture("acceleration", pictures.draw_acceleration, (9.0, 1.2 + 2.6 * len(jolted)))
    yield from _ring_pictures(results)
    yield from _joint_pictures(results)
    if _rows(results, "windows/time") > 1 and pictures.energy_rows(results):
        rows = pictures.energy_rows(results)
        yield Picture("energy", pictures.draw_energy, (10.0, 1.0 + 2.6 * rows))
    if _rows(results, "windows/time") > 1 and "windows/step_min" in results:
        yield Picture("steps", pictures.draw_steps, (9.0, 6.5))


def _light_pictures(results: Results) -> Iterator[Picture]:
    """Of recorded skins, and of sun and planet over time."""
    if light_pictures.lit_skins(results):
        lit = partial(light_pictures.draw_facets, by=light_pictures.LIGHT)
        yield Picture("light", lit, (12.8, 7.2))
    if light_pictures.bulky_skins(results):
        warm = partial(light_pictures.draw_facets, by=light_pictures.TEMPERATURE)
        yield Picture("solid_temperature", warm, (12.8, 7.2))
    rows = skin_pictures.map_rows(results)
    if rows:
        yield Picture("skin_temperature", skin_pictures.draw_maps, (13.0, 1.0 + 1.9 * rows))
    if _rows(results, "sky/time") > 1 and light_pictures.powers(results):
        height = 1.2 + 2.4 * light_pictures.sky_rows(results)
        yield Picture("sky", light_pictures.draw_sky, (10.0, height))


def _runs_forward(results: Results) -> bool:
    """Whether there are frames, each later than the one before; a path may turn back."""
    times = results["frames/time"] if "frames/time" in results else np.zeros(0)
    return len(times) > 1 and bool(np.all(np.diff(times) > 0.0))


def _joint_pictures(results: Results) -> Iterator[Picture]:
    """Of joints with clearance, of the most loaded ones if there are many, and of all of them."""
    joints = contact_groups(results)
    joints = {j: c for j, c in joints.items() if _rows(results, f"joints/{c[0]}/normal_force") > 1}
    peak = {j: max(peak_force(results, c) for c in contacts) for j, contacts in joints.items()}
    chosen = sorted(joints, key=lambda j: -peak[j])[:MOST_JOINTS]
    for joint in chosen:
        suffix = f"_{joint}" if len(joints) > 1 else ""
        for name, draw, size in _of_joint(results, joint, joints[joint]):
            yield Picture(name + suffix, partial(draw, joint=joint), size)
    rows = contact_maps.regime_rows(results)
    if rows > FEW_CONTACTS:
        height = min(4.0 + 0.12 * rows, 14.0)
        yield Picture("regimes", contact_maps.draw_regimes, (13.0, height))


def _ring_pictures(results: Results) -> Iterator[Picture]:
    """Of a ring that deploys."""
    ring = deployment_pictures.ring_of(results)
    if ring is None or len(ring.time) < 2:
        return
    if deployment_pictures.deploys(ring):
        yield Picture("deployment", deployment_pictures.draw_deployment, (14.0, 6.4))
    if deployment_pictures.warms_or_cools(results):
        yield Picture("paths", deployment_pictures.draw_paths, (14.0, 7.0))
    if deployment_pictures.has_hinges(results):
        yield Picture("hinge", deployment_pictures.draw_hinge, (12.0, 5.0))


def _of_joint(results: Results, joint: str, contacts: list[str]) -> Iterator[Any]:
    """Names, functions and sizes of the pictures of one joint."""
    if len(contacts) > FEW_CONTACTS:
        yield "map", contact_maps.draw_map, (11.0, 9.0)
    if form_of(results, contacts[0]) == TUBE and "contacts/shares" in results:
        yield "surfaces", telescope_pictures.draw_surfaces, (12.0, 8.0)
        yield "snapshot", telescope_pictures.draw_snapshot, (14.0, 7.5)
    if len(contacts) > FEW_CONTACTS:
        return
    if contact_pictures.round_contacts(results, joint):
        yield "orbit", contact_pictures.draw_orbit, (11.0, 5.6)
        if turning_pictures.has_stages(results, joint):
            yield "stages", turning_pictures.draw_stages, (14.0, 5.0)
        if turning_pictures.is_warm(results, joint):
            yield "stick_slip", turning_pictures.draw_stick_slip, (11.0, 7.0)
    height = 7.0 if len(contacts) == 1 else 8.0 + 0.5 * len(contacts)
    yield "contact", contact_pictures.draw_contact, (10.0, height)


def _rows(results: Results, column: str) -> int:
    return len(results[column]) if column in results else 0
