"""What there is to choose from: ``thermobody list``."""

import tomllib
from collections.abc import Iterable
from pathlib import Path

from rich.console import Console
from rich.text import Text

from coupling.casefile import FILE_NAME
from coupling.joint_references import SIDES
from coupling.verify.registry import AREAS
from mechanics.contact import DISSIPATION, EXPONENT
from mechanics.elements import FAMILIES
from meshes.materials import Material, library, library_material
from thermal.solvers import SOLVERS


def show(out: Console, folder: Path = Path("cases")) -> None:
    """Print all that a case may name, and the cases in ``folder``."""
    _section(out, f"cases under ./{folder}", _cases(folder))
    _section(out, "materials", [(n, _range(library_material(n))) for n in library()])
    _section(out, "thermal solvers  (thermal.solver)", _bare(SOLVERS))
    _section(out, "elements  (body.NAME.kind: beam, cable, particle)", _bare(FAMILIES))
    _section(out, "joints  (joint.NAME.kind)", _bare(SIDES))
    _section(out, "contact stiffness  (contact.stiffness)", _bare(EXPONENT))
    _section(out, "hysteresis laws  (contact.dissipation)", _bare(DISSIPATION))
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
