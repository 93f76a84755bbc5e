"""Tables of the case file about sweeps: [sweep.NAME].

A sweep runs the case at many points, those of a grid or of a design of experiments, and keeps
quantities and phase portraits of each. ``thermobody sweep CASE NAME`` makes it; a run takes no
notice of it.
"""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from coupling.fields import Count, PositiveTime, Table, Time
from coupling.report_tables import Measured, Overrides, Varied
from coupling.scales import Course, Scale, scale

MOST = 5000
"""Points of one sweep, at most."""
MOST_FACTORS = 20
Kind = Literal["full-factorial", "fractional-factorial", "central-composite", "box-behnken",
               "latin-hypercube", "sobol"]  # fmt: skip
SPREAD = ("latin-hypercube", "sobol")
"""Designs that fill the space between low and high."""
CURVED = ("central-composite", "box-behnken")
"""Designs for quadratic responses, whose factors have values between low and high."""


class Design(Table):
    """[sweep.NAME.design]: a design of experiments."""

    kind: Kind = Field(description="which combinations of the factors are run")
    runs: Annotated[int, Count(most=MOST)] | None = Field(
        default=None, description="of latin-hypercube and sobol; of fractional-factorial: 4, 8, ..."
    )
    seed: Annotated[int, Count(least=0, most=2**31)] | None = Field(
        default=None, description="of latin-hypercube and sobol; default: 1"
    )
    resolution: Literal[3, 4, 5] | None = Field(
        default=None,
        description="of fractional-factorial, at least: 3 separates main effects from each other, "
        "4 from interactions, 5 interactions from each other; default: 4",
    )
    axial: Literal["faced", "inscribed", "circumscribed"] | None = Field(
        default=None,
        description="of central-composite: points on the axes at low and high with the corners "
        "there too; the same with the corners inside, rotatable; or beyond low and high, "
        "rotatable; default: faced",
    )
    centre: Annotated[int, Count(least=0, most=100)] | None = Field(
        default=None,
        description="of central-composite, box-behnken and factorials: points in the middle; "
        "default: 1, of factorials 0. The program repeats itself exactly: more tell nothing",
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        factorial = "full-factorial", "fractional-factorial"
        owners = {
            "runs": (*SPREAD, "fractional-factorial"),
            "seed": SPREAD,
            "resolution": ("fractional-factorial",),
            "axial": ("central-composite",),
            "centre": (*CURVED, *factorial),
        }
        for key, kinds in owners.items():
            if getattr(self, key) is not None and self.kind not in kinds:
                yield key, f"belongs to {' and '.join(kinds)}, and this is {self.kind}"
        if self.kind in SPREAD and self.runs is None:
            yield "runs", f"missing (number of points of {self.kind})"
        if self.kind == "fractional-factorial" and self.runs is not None:
            if self.runs & (self.runs - 1) or self.runs < 4:
                yield "runs", f"expected a power of two from 4 on, got {self.runs}"
            if self.resolution is not None:
                yield "resolution", "follows from runs where those are given"
        if self.kind == "sobol" and self.runs is not None and self.runs & (self.runs - 1):
            yield "runs", f"expected a power of two, got {self.runs}: others lose the balance"


class Factor(Table):
    """[sweep.NAME.factor.NAME]: what a design varies, one entry or several together."""

    entries: list[str] = Field(description="paths of the entries, which all get the same value")
    low: float | int | str | None = Field(default=None, description="such as '10 um'")
    high: float | int | str | None = Field(default=None, description="such as '100 um'")
    scale: Course | None = Field(
        default=None, description="of the values between low and high; default: linear"
    )
    levels: list[Any] | None = Field(
        default=None, description="values in place of low and high, also such as names of laws"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if not self.entries:
            yield "entries", "names no entry"
        given = [key for key in ("low", "high") if getattr(self, key) is not None]
        if self.levels is not None:
            yield from ((key, "levels stand in its place") for key in given)
            if self.scale is not None:
                yield "scale", "belongs to low and high, and this has levels"
            if len(self.levels) < 2:
                yield "levels", f"expected two or more, got {len(self.levels)}"
            return
        lacking = [key for key in ("low", "high") if key not in given]
        yield from ((key, "missing (low and high, or levels)") for key in lacking)
        if not lacking:
            yield from self._odd_scale()

    def _odd_scale(self) -> Iterator[tuple[str, str]]:
        try:
            _ = self.between
        except ValueError as error:
            yield "high", str(error)

    @property
    def between(self) -> Scale:
        """What lies between low and high. Raises ValueError."""
        low, high = self.low, self.high
        assert low is not None and high is not None
        return scale(low, high, self.scale or "linear")

    @property
    def count(self) -> int:
        """Number of levels; 2 of low and high."""
        return len(self.levels) if self.levels is not None else 2

    def value(self, coded: float) -> Any:
        """Entry at a coded value: -1 is low or the first level, 1 high or the last one."""
        place = 0.5 * (coded + 1.0)
        if self.levels is None:
            return self.between.written(place)
        return self.levels[min(int(place * len(self.levels)), len(self.levels) - 1)]

    def coded(self, level: int) -> float:
        """Coded value of a level."""
        return 2.0 * level / (self.count - 1) - 1.0


class Swept(Measured):
    """[sweep.NAME.quantity.NAME]: a number kept of each point."""

    after: Time = Field(default=0.0, description="the measure is of the time from here on")
    printed: list[float] | None = Field(
        default=None,
        description="SI; what a source prints for the points in their order, drawn beside; nan "
        "where it prints nothing",
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.measure == "course":
            yield "measure", "a sweep keeps one number of a point; courses are kept of [portrait]"


class Portrait(Table):
    """[sweep.NAME.portrait.NAME]: a phase portrait of each point, with how regular it is."""

    x: str = Field(description="a quantity, such as probe.root.rz")
    y: str = Field(description="its rate, such as probe.root.wz")
    after: Time = Field(default=0.0, description="what comes before is left out of the measure")
    period: PositiveTime | None = Field(
        default=None, description="of the drive, for stroboscopic sections"
    )


class SweepTable(Varied):
    """[sweep.NAME]: the case at many points."""

    title: str = Field(default="", description="of table and pictures")
    variant: list[str] = Field(
        default_factory=list, description="names of [variant.NAME] that every point takes first"
    )
    set: Overrides = Field(default_factory=dict, description="overrides of every point")
    design: Design | None = Field(default=None, description="in place of vary")
    factor: dict[str, Factor] = Field(default_factory=dict, description="of the design, by name")
    quantity: dict[str, Swept] = Field(default_factory=dict, description="what is kept, by name")
    portrait: dict[str, Portrait] = Field(default_factory=dict, description="by name")
    limit: PositiveTime | None = Field(
        default=None, description="of the wall clock; a point that takes longer is given up"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        yield from super().odd_values()
        if not self.quantity and not self.portrait:
            yield "quantity", "missing (what is kept of each point)"
        if self.design is None:
            yield from self._odd_grid()
        else:
            yield from self._odd_design(self.design)
        yield from self._odd_printed()

    def _odd_grid(self) -> Iterator[tuple[str, str]]:
        if not self.vary:
            yield "vary", "missing (entries to vary, or a design with factors)"
        if self.factor:
            yield "factor", "belongs to a design, and there is no [sweep.NAME.design]"
        yield from _too_many("vary", self)

    def _odd_design(self, design: Design) -> Iterator[tuple[str, str]]:
        if self.vary:
            yield "vary", "a design takes its place"
        least = 3 if design.kind in ("box-behnken", "fractional-factorial") else 1
        if len(self.factor) < least:
            text = "too few" if self.factor else "missing (a table [sweep.NAME.factor.NAME] each)"
            yield "factor", f"{text}; {design.kind} takes {least} or more"
            return
        if len(self.factor) > MOST_FACTORS:
            yield "factor", f"at most {MOST_FACTORS}, got {len(self.factor)}"
            return
        found = [*_odd_levels(design, self.factor)]
        yield from found or _too_many("design", self)

    def _odd_printed(self) -> Iterator[tuple[str, str]]:
        printed = {k: q.printed for k, q in self.quantity.items() if q.printed is not None}
        try:
            count = len(self.settings()) if printed else 0
        except (ValueError, TypeError, KeyError, ZeroDivisionError):
            return  # what is wrong with the points has been said
        for key, values in printed.items():
            if len(values) != count:
                yield (
                    "quantity",
                    (f"'{key}' has {len(values)} printed values, and there are {count} points"),
                )

    def settings(self) -> list[Overrides]:
        """Overrides of each point in their order, without what they have in common."""
        if self.design is None:
            return [{**of_curve, **of_point} for of_curve, of_point in self.points()]
        rows = self.coded()
        return [
            {path: factor.value(c) for c, factor in zip(row, self.factor.values(), strict=True)
             for path in factor.entries}
            for row in rows
        ]  # fmt: skip

    def coded(self) -> list[list[float]]:
        """Coded values of the factors at each point of the design: -1 is low, 1 is high."""
        from coupling.sweeps.designs import coded

        assert self.design is not None
        return [list(map(float, row)) for row in coded(self.design, [*self.factor.values()])]


def _odd_levels(design: Design, factors: dict[str, Factor]) -> Iterator[tuple[str, str]]:
    """Factors whose levels a design cannot take."""
    for name, factor in factors.items():
        if design.kind in CURVED and factor.levels is not None:
            yield "factor", f"'{name}' has levels, and {design.kind} takes low and high"
        if design.kind == "fractional-factorial" and factor.count != 2:
            yield "factor", f"'{name}' has {factor.count} levels, and {design.kind} takes two"
        if design.centre and factor.levels is not None:
            yield "factor", f"'{name}' has levels, and points in the middle take low and high"


def _too_many(key: str, table: SweepTable) -> Iterator[tuple[str, str]]:
    try:
        count = len(table.settings())
    except ValueError as error:
        yield key, str(error)
        return
    if count > MOST:
        yield key, f"makes {count} points; at most {MOST} can be run"
