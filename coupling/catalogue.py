"""What there is to choose from: ``thermobody list``."""

import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import get_args

from rich.console import Console
from rich.text import Text

from coupling.casefile import FILE_NAME
from coupling.crosscheck_tables import STAGES
from coupling.generators import KINDS
from coupling.joint_references import SIDES
from coupling.paper.sections import SECTIONS
from coupling.reports.registry import OF_A_CASE, OWN
from coupling.scene import Analysis, Integrator
from coupling.surface_tables import SURFACES
from coupling.verify.registry import AREAS
from mechanics.contact import DISSIPATION
from meshes.materials import Material, library, library_material

ELEMENTS = {
    "beam3243": "beam, the default: shears, bends, twists; 12 coordinates per node",
    "beam3243-continuum": "as printed in textbooks: locks",
    "beam3243-enhanced": "with enhanced continuum mechanics",
    "beam3333": "three nodes, of higher order, for comparison",
    "cable": "stretches and bends",
    "shell48": "thin shell, bicubic",
    "shell24": "thick shell",
    "shell3443": "fully parametrised shell, for comparison",
    "rigid": "rigid body",
    "particle": "point mass",
}
"""What the elements are, by their names in ``mechanics.elements.FAMILIES``."""
HEAT = {
    "line": "finite elements along beams and cables, trigonometric round tubes; shells as walls",
    "hermite": "the same by the cubic functions of the beams along the axis",
    "wall": "finite elements on the developed walls of tubes and on shells",
    "solid": "3D finite elements of everything",
    "lumped": "a network of lumps and conductors, integrated by TR-BDF2",
    "prescribed": "walls and fields give all temperatures; nothing is computed",
    "calculix": "the 3D problem written as a deck and solved by CalculiX, where it is installed",
}
"""What ``thermal.solvers.SOLVERS`` do."""
NORMAL = {
    "hertz-external": "two spheres side by side, as Hua et al. (2026) take them",
    "hertz-internal": "a sphere in a hollow one",
    "cylinder": "a pin in a bore of some length (Johnson)",
    "linear": "a spring",
}
"""What the normal laws of ``mechanics.contact.STIFFNESS`` are."""
FRICTION = {
    "regularised": "Coulomb, smooth about rest: creeps",
    "stick": "Coulomb that truly sticks, by bristles",
    "stribeck": "regularised, falls from static to kinetic with speed",
    "lugre": "bristles that bend and slip (Canudas de Wit et al. 1995)",
    "rising": "sticks; the bound rises while it does",
}
"""What the friction laws of ``mechanics.contact.FRICTION`` are."""
DESIGNS = {
    "full-factorial": "all combinations of levels",
    "fractional-factorial": "of two levels, a half or less, of a resolution (Box & Hunter 1961)",
    "central-composite": "corners, axes, middle: a quadratic response (Box & Wilson 1951)",
    "box-behnken": "the same of 3 to 7 factors without corners (Box & Behnken 1960)",
    "latin-hypercube": "so many runs that fill the space, each layer once",
    "sobol": "a power of two of runs that fill the space evenly",
}
"""What the designs of ``coupling.sweeps.designs`` are."""
ANALYSES = get_args(Analysis.model_fields["kind"].annotation)
SCHEMES = get_args(Integrator.model_fields["scheme"].annotation)


def show(out: Console, folder: Path = Path("cases")) -> None:
    """Print all that a case may name, and the cases in ``folder``."""
    _section(out, f"cases under ./{folder}", _cases(folder))
    _section(out, "materials", [(n, _range(library_material(n))) for n in library()])
    _section(out, "thermal solvers  (thermal.solver)", [*HEAT.items()])
    _section(out, "elements  (of bodies: kind or element)", [*ELEMENTS.items()])
    _section(out, "surfaces of shells  (body.NAME.surface.kind)", _bare(SURFACES))
    _section(out, "joints  (joint.NAME.kind)", _bare(SIDES))
    _section(out, "contact stiffness  (joint.NAME.contact.stiffness)", [*NORMAL.items()])
    _section(out, "hysteresis laws  (joint.NAME.contact.dissipation)", _bare(DISSIPATION))
    _section(out, "friction laws  (joint.NAME.friction.law)", [*FRICTION.items()])
    _section(out, "analyses  (analysis.kind)", _bare(ANALYSES))
    _section(out, "schemes  (integrator.scheme)", _bare(SCHEMES))
    _section(out, "generated structures  (generate.NAME.kind)", _bare(KINDS))
    _section(out, "stages of a cross-check  (crosscheck.stages)", [*STAGES.items()])
    _section(out, "designs of sweeps  (sweep.NAME.design.kind)", [*DESIGNS.items()])
    of_a_case = [*OF_A_CASE, "and its tables [report.NAME]"]
    _section(out, "reports of a case  (thermobody report CASE NAME)", _bare(of_a_case))
    for what, reports in OWN.items():
        _section(out, f"reports  (thermobody report {what} NAME)", _bare(reports))
    _section(out, "sections of the report on the paper  (thermobody report paper NAME)",
             _bare(SECTIONS))  # fmt: skip
    _section(out, "verification areas  (thermobody verify AREA)", _bare(AREAS))


def _section(out: Console, title: str, rows: Iterable[tuple[str, str]]) -> None:
    rows = list(rows)
    width = max((len(name) for name, _ in rows), default=0)
    out.print(Text(title, "bold"))
    for name, text in rows or [("none", "")]:
        out.print(f"  {name:<{width}}  {text}".rstrip(), markup=False)


def _bare(names: Iterable[str]) -> list[tuple[str, str]]:
    """Names alone, on one line."""
    return [(", ".join(names), "")]


def _cases(folder: Path) -> list[tuple[str, str]]:
    return [(str(file.parent), _title(file)) for file in sorted(folder.glob(f"*/{FILE_NAME}"))]


def _title(file: Path) -> str:
    try:
        title = tomllib.loads(file.read_text(encoding="utf-8")).get("title", "")
    except (OSError, ValueError):
        return "(cannot be read; thermobody check says why)"
    return str(title)


def _range(material: Material) -> str:
    """The temperatures that the data of all properties cover."""
    lower = max(p.lower for p in material.properties)
    upper = min(p.upper for p in material.properties)
    return f"{lower:g} K to {upper:g} K"
