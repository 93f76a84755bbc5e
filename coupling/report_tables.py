"""Tables of the case file about error against run time: [report.NAME].

A report runs the case under many settings and compares chosen quantities with a finer run, or with
numbers that are known. ``thermobody report CASE NAME`` makes it; a run takes no notice of it.
"""

import re
from collections.abc import Iterator
from itertools import product
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field

from coupling import quantities
from coupling.fields import Count, PositiveTime, Quantity, Table
from coupling.overrides import literal

Overrides = dict[str, Any]
"""Entries of the case by their paths, such as ``"integrator.tolerance"``, and what to put there."""
Measure = Literal["final", "max", "min", "mean", "rms", "range", "amplitude", "course"]
PositiveNumber = Annotated[float, Quantity(quantities.NUMBER, above=0.0)]
MOST = 200
"""Settings of one report, at most."""


class Variant(NamedTuple):
    """One setting: curve that it belongs to, its name on the curve, overrides."""

    curve: str
    name: str
    overrides: Overrides

    @property
    def label(self) -> str:
        """Both names."""
        return ", ".join(filter(None, (self.curve, self.name)))


class Measured(Table):
    """A quantity, and what is measured of it."""

    of: str = Field(
        description="what: probe.NAME.x (y, z, position, vx, ..., ax, ..., rx, ..., wx, ..., "
        "temperature), joint.NAME.angle (rate), body.NAME.mean (gradient), part.NAME.temperature, "
        "heat.max (min, mean), ledger.TERM, contact.NAME.peak_force (impacts, friction_work, "
        "hysteresis; x, y, vx, vy, force, radius_gap), mode.NUMBER.frequency, load_factor"
    )
    measure: Measure = Field(
        default="final",
        description="of its values at the ends of the windows; range: max - min; amplitude: half "
        "of it; course: all of them, whose largest distance from the reference at the same times "
        "counts",
    )


class Sought(Measured):
    """[report.NAME.quantity.NAME]: a number to compare."""

    scale: PositiveNumber | None = Field(
        default=None,
        description="SI; errors are divided by it; default: the size of the reference's value",
    )
    exact: float | list[float] | None = Field(
        default=None, description="SI; known from elsewhere, in place of the reference's value"
    )
    wanted: PositiveNumber | None = Field(
        default=None, description="error under which the cheapest setting is sought"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.exact is not None and self.measure == "course":
            yield "exact", "is one value, and measure = 'course' compares a whole course"


class Varied(Table):
    """What is varied along a curve."""

    vary: dict[str, list[Any]] = Field(
        default_factory=dict, description="paths of entries, and their values one after the other"
    )
    combine: Literal["grid", "together"] = Field(
        default="grid",
        description="several entries: all combinations, the last one along the curve; or their "
        "values side by side",
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        for path, values in self.vary.items():
            if not values:
                yield "vary", f"'{path}' has no values"
        if self.combine == "together" and len({len(v) for v in self.vary.values()}) > 1:
            counts = ", ".join(f"'{p}' has {len(v)}" for p, v in self.vary.items())
            yield "combine", f"'together' takes as many values of each entry: {counts}"

    def points(self) -> list[tuple[Overrides, Overrides]]:
        """Overrides that name the curve and those that name the point, of each setting."""
        paths = list(self.vary)
        if self.combine == "together" or len(paths) < 2:
            rows = list(zip(*self.vary.values(), strict=False)) if paths else [()]
            return [({}, dict(zip(paths, row, strict=True))) for row in rows]
        return [
            (dict(zip(paths[:-1], row[:-1], strict=True)), {paths[-1]: row[-1]})
            for row in product(*self.vary.values())
        ]


class Setting(Varied):
    """[[report.NAME.setting]]: a curve, or a single point."""

    label: str = Field(description="in table and picture")
    set: Overrides = Field(default_factory=dict, description="overrides, {path = value}")


class ReportTable(Varied):
    """[report.NAME]: error against run time."""

    title: str = Field(default="", description="of table and picture")
    common: Overrides = Field(
        default_factory=dict, description="overrides of all runs, such as a shorter time.end"
    )
    reference: Overrides | None = Field(
        default=None, description="overrides of the run whose values the others are compared with"
    )
    check: Overrides | None = Field(
        default=None,
        description="overrides of a second reference, somewhat coarser: how far it is from the "
        "first tells how far that is from the truth",
    )
    setting: list[Setting] = Field(
        default_factory=list, description="each with vary of its own, or that of the report"
    )
    quantity: dict[str, Sought] = Field(description="what is compared, by name")
    repeat: Annotated[int, Count(most=1000)] = Field(default=3, description="timed runs of each")
    budget: PositiveTime = Field(
        default=10.0, description="once the timed runs of a setting took so long, no more follow"
    )
    limit: PositiveTime = Field(
        default=60.0, description="a setting that takes longer is given up after a window"
    )
    wanted: PositiveNumber | None = Field(
        default=None, description="of each quantity that names none of its own"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        yield from super().odd_values()
        if not self.quantity:
            yield "quantity", "names nothing to compare"
        lacking = [name for name, sought in self.quantity.items() if sought.exact is None]
        if lacking and self.reference is None:
            yield "reference", f"missing, and quantity '{lacking[0]}' has no exact value"
        if self.check is not None and self.reference is None:
            yield "check", "belongs to a reference"
        if not self.vary and not self.setting:
            yield "vary", "missing (entries to vary, or [[report.NAME.setting]])"
        elif len(self.variants()) > MOST:
            yield "vary", f"makes {len(self.variants())} settings; at most {MOST} can be run"

    def variants(self) -> list[Variant]:
        """All settings in their order, without what they have in common."""
        found = []
        for setting in self.setting or [Setting.model_construct(label="", set={}, vary={})]:
            varied = setting if setting.vary else self
            for of_curve, of_point in varied.points():
                curve = ", ".join(filter(None, (setting.label, said(of_curve))))
                together = {**setting.set, **of_curve, **of_point}
                found.append(Variant(curve, said(of_point), together))
        return found


def said(overrides: Overrides) -> str:
    """Overrides in words, by the last key of each path."""
    return ", ".join(f"{path.rpartition('.')[2]} {_short(v)}" for path, v in overrides.items())


def _short(value: Any) -> str:
    """A value, numbers as they are written by hand."""
    if isinstance(value, float):
        return re.sub(r"e([+-])0*", lambda m: "e" + m[1].strip("+"), f"{value:g}")
    return value if isinstance(value, str) else literal(value)
