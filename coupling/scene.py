"""The scene: what a case file says, checked and in SI units and kelvin.

``Scene`` mirrors the tables of the file. Named tables are dicts by name, empty when the file has
none; ``gravity`` and ``thermal`` are None when absent. ``coupling.casefile.read`` makes a scene.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field
from pydantic.json_schema import SkipJsonSchema

from coupling import quantities
from coupling.body_tables import Body
from coupling.crosscheck_tables import Crosscheck
from coupling.fields import Count, Point, PositiveTime, Quantity, Table, Time
from coupling.generators import Generator
from coupling.heat_tables import MaterialTable, Thermal
from coupling.joint_tables import Joint
from coupling.load_tables import Gravity, Load
from coupling.mechanics_tables import MechanicsTable
from coupling.report_tables import ReportTable
from coupling.section_tables import Section
from coupling.site_tables import Place
from coupling.sweep_tables import SweepTable
from coupling.variant_tables import Variant

Ratio = Annotated[float, Quantity(quantities.NUMBER, above=0.0, most=1.0)]

ROOM_TEMPERATURE = 293.15  # [K] of a body without any temperature given


class Span(Table):
    """[time]: how long, and in which windows heat and motion exchange."""

    end: PositiveTime = Field(description="length of the run, a whole number of windows")
    window: PositiveTime = Field(description="coupling window")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        n = round(self.end / self.window)
        if n < 1 or abs(self.end / self.window - n) > 1e-9 * n:
            yield (
                "end",
                f"must be a whole number of windows of {self.window:g} s, got {self.end:g} s",
            )
        elif n > 100_000_000:
            yield "window", f"makes {n} windows; at most 1e8 can be run"

    @property
    def windows(self) -> int:
        """Number of windows."""
        return round(self.end / self.window)


class Adaptive(Table):
    """[coupling.adaptive]: windows as short as heat and motion ask for, time.window at the most."""

    change: Ratio = Field(
        default=0.01, description="largest relative change of temperature-dependent coefficients"
    )
    tolerance: Ratio = Field(
        default=1e-3,
        description="largest relative error of those coefficients by predicted temperatures",
    )
    iterations: Annotated[int, Count()] = Field(
        default=8, description="of the scheme iterated; after more, windows become shorter"
    )


class Coupling(Table):
    """[coupling]: how heat and motion are coupled."""

    scheme: Literal["serial", "parallel", "corrected", "iterated"] = Field(
        default="corrected",
        description="serial: heat, then motion, first order in the window; parallel: each from "
        "what the last window left, first order; corrected: heat, motion, heat, second order in "
        "friction; "
        "iterated: until both agree, second order",
    )
    acceleration: Literal["none", "relaxation", "aitken", "quasi-newton"] | None = Field(
        default=None, description="of iterated; default: quasi-newton"
    )
    relaxation: Ratio | None = Field(
        default=None,
        description="of iterated: factor of relaxation, first factor of aitken and quasi-newton; "
        "default: 1, of relaxation 0.5",
    )
    temperature_tolerance: Ratio | None = Field(
        default=None,
        description="of iterated: last change of temperatures, over that in the window; "
        "default: 1e-4",
    )
    heat_tolerance: Ratio | None = Field(
        default=None,
        description="of iterated: last change of exchanged heat, over all of it; default: 1e-4",
    )
    most_iterations: Annotated[int, Count(most=1000)] | None = Field(
        default=None, description="of iterated, before the window is halved; default: 50"
    )
    reused_windows: Annotated[int, Count(least=0, most=1000)] | None = Field(
        default=None, description="of quasi-newton: windows that it remembers; default: 2"
    )
    density: Literal["constant", "temperature"] = Field(
        default="constant",
        description="temperature: mass follows the density of the material, for comparison; it "
        "is not kept then",
    )
    smallest_window: PositiveTime | None = Field(
        default=None, description="a window is halved down to this before the run stops"
    )
    adaptive: Adaptive | None = None

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.adaptive and self.scheme in ("serial", "parallel"):
            yield "adaptive", f"belongs to corrected and iterated: {self.scheme} corrects nothing"
        if self.scheme != "iterated":
            for key in ITERATION:
                if getattr(self, key) is not None:
                    yield key, f"belongs to the scheme iterated, and this one is {self.scheme}"
            if self.adaptive and "iterations" in self.adaptive.model_fields_set:
                text = f"belongs to the scheme iterated, and this one is {self.scheme}"
                yield "adaptive.iterations", text
            return
        kind = self.acceleration or "quasi-newton"
        if self.relaxation is not None and kind == "none":
            yield "relaxation", "belongs to accelerations other than none"
        if self.reused_windows is not None and kind != "quasi-newton":
            yield "reused_windows", f"belongs to the acceleration quasi-newton, this one is {kind}"

    @property
    def iteration(self) -> dict[str, Any]:
        """Settings of ``coupling.iteration.Iterated``: those that are given."""
        given = {name: getattr(self, key) for key, name in ITERATION.items()}
        if self.acceleration == "relaxation":
            given["factor"] = given["factor"] or 0.5
        return {name: value for name, value in given.items() if value is not None}


ITERATION = {
    "acceleration": "acceleration",
    "relaxation": "factor",
    "temperature_tolerance": "temperature_tolerance",
    "heat_tolerance": "heat_tolerance",
    "most_iterations": "most",
    "reused_windows": "reused",
}
"""Keys of the scheme iterated, and what ``coupling.iteration`` calls them."""


class Integrator(Table):
    """[integrator]: steps in time of the motion."""

    scheme: Literal["hht", "generalised-alpha", "bdf2", "backward-euler"] = Field(
        default="hht", description="the last two damp what is fast, for comparison and stiff starts"
    )
    alpha: Annotated[float, Quantity(quantities.NUMBER, least=-1 / 3, most=0.0)] | None = Field(
        default=None, description="of hht: numerical damping, from -1/3 to 0 (none); default -0.1"
    )
    spectral_radius: Annotated[float, Quantity(quantities.NUMBER, least=0.0, most=1.0)] | None = (
        Field(
            default=None,
            description="of generalised-alpha, at high frequencies: 1 damps nothing; default 0.8",
        )
    )
    constraints: Literal["index3", "projected", "baumgarte"] = Field(
        default="index3",
        description="index3: positions obey the joints at every step; projected: velocities as "
        "well; baumgarte: violations decay, for comparison",
    )
    baumgarte_rate: Annotated[float, Quantity(quantities.RATE, above=0.0)] | None = Field(
        default=None, description="of baumgarte: decay of violations; default: 2 / step"
    )
    solver: Literal["auto", "blocks", "superlu", "pardiso", "umfpack", "dense"] = Field(
        default="auto", description="of the linear systems; auto: by size, and what is installed"
    )
    tolerance: Annotated[float, Quantity(quantities.NUMBER, above=0.0, most=0.1)] = Field(
        default=1e-6,
        description="local error per step, relative to body size; to 1000 clearances for journals",
    )
    largest_step: PositiveTime | None = Field(
        default=None, description="default: the coupling window"
    )
    smallest_step: PositiveTime | None = Field(default=None, description="default: 1e-9 windows")
    newton_tolerance: Annotated[float, Quantity(quantities.NUMBER, above=0.0, most=0.1)] = Field(
        default=1e-12, description="largest remaining correction, relative to body size"
    )

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.largest_step and self.smallest_step and self.smallest_step > self.largest_step:
            yield "smallest_step", f"must not exceed largest_step, {self.largest_step:g} s"
        for key, scheme in (("alpha", "hht"), ("spectral_radius", "generalised-alpha")):
            if getattr(self, key) is not None and self.scheme != scheme:
                yield key, f"belongs to the scheme {scheme}, and this one is {self.scheme}"
        if self.baumgarte_rate is not None and self.constraints != "baumgarte":
            yield "baumgarte_rate", "belongs to constraints = 'baumgarte'"


class Damping(Table):
    """[damping]: Rayleigh's, of all flexible bodies; that of [body.NAME] is free of its faults.

    It slows rigid motion down, and rotation as well.
    """

    mass: Annotated[float, Quantity(quantities.RATE, least=0.0)] = Field(
        default=0.0, description="factor of the mass matrix"
    )
    stiffness: Time = Field(default=0.0, description="factor of the stiffness at the start")


class Analysis(Table):
    """[analysis]: what is computed. In statics histories run over the load factor, from 0 to 1."""

    kind: Literal["dynamics", "statics", "modes"] = Field(
        default="dynamics",
        description="statics: equilibrium; modes: vibrations about the equilibrium",
    )
    start: Literal["reference", "equilibrium"] = Field(
        default="reference",
        description="where motion begins; equilibrium: at the loads and temperatures of t = 0",
    )
    steps: Annotated[int, Count()] = Field(default=10, description="of the load, in statics")
    arc_length: bool = Field(
        default=False,
        description="true: follow the path of equilibria, through limit points; loads must go on "
        "growing beyond the load factor 1",
    )
    most_points: Annotated[int, Count()] = Field(
        default=200, description="of a path, with arc_length"
    )
    count: Annotated[int, Count()] = Field(default=10, description="number of modes")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.start == "equilibrium" and self.kind != "dynamics":
            yield "start", f"belongs to dynamics, and this is {self.kind}"


class Probe(Table):
    """A point whose motion and temperature are written to probes.csv."""

    body: str = Field(description="name of a [body.NAME]")
    at: Place | None = Field(
        default=None,
        description="on a beam or cable: 'start', 'end' or the distance from the start along it",
    )
    position: Point | None = Field(
        default=None,
        description="point [x, y, z] at the start of a rigid body (default: its centre of mass), "
        "or the node of a shell that is there",
    )
    offset: Point | None = Field(
        default=None, description="from there along e1, e2, e3 of the section, carried with it"
    )


class Output(Table):
    """[output]"""

    frames: Annotated[int, Count(most=1_000_000)] = Field(default=100, description="about how many")
    export: list[Literal["vtk", "pictures"]] = Field(
        default_factory=list, description="what is written after the run"
    )
    skins: list[str] = Field(
        default_factory=list,
        description="names of bodies and solids whose faces are recorded with their temperature "
        "and the light that they absorb",
    )


class Scene(BaseModel):
    """A case: everything that its file says.

    Attributes
    ----------
    shapes : dict  where each body is at the start, by name; see ``coupling.places``
    folder : Path  of the case
    text : str  the TOML that was read, with overrides applied
    overrides : tuple of str  those overrides, as given
    """

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)

    title: str = Field(default="", description="one line")
    description: str = Field(default="", description="free text")
    time: Span
    coupling: Coupling = Field(default_factory=Coupling)
    integrator: Integrator = Field(default_factory=Integrator)
    analysis: Analysis = Field(default_factory=Analysis)
    damping: Damping | None = None
    mechanics: MechanicsTable = Field(default_factory=MechanicsTable)
    generate: dict[str, Generator] = Field(default_factory=dict)
    material: dict[str, MaterialTable] = Field(default_factory=dict)
    section: dict[str, Annotated[Section, Field(discriminator="kind")]] = Field(
        default_factory=dict
    )
    body: dict[str, Annotated[Body, Field(discriminator="kind")]]
    joint: dict[str, Annotated[Joint, Field(discriminator="kind")]] = Field(default_factory=dict)
    load: dict[str, Annotated[Load, Field(discriminator="kind")]] = Field(default_factory=dict)
    gravity: Gravity | None = None
    thermal: Thermal | None = None
    probe: dict[str, Probe] = Field(default_factory=dict)
    output: Output = Field(default_factory=Output)
    report: dict[str, ReportTable] = Field(default_factory=dict)
    sweep: dict[str, SweepTable] = Field(default_factory=dict)
    variant: dict[str, Variant] = Field(default_factory=dict)
    crosscheck: Crosscheck | None = None
    shapes: SkipJsonSchema[dict[str, Any]] = Field(default_factory=dict)
    folder: SkipJsonSchema[Path] = Path()
    text: SkipJsonSchema[str] = ""
    overrides: SkipJsonSchema[tuple[str, ...]] = ()

    @property
    def points(self) -> dict[str, Any]:
        """(n, 3) float [m]  nodes of each body by name at the start, one for a particle."""
        return {name: shape.points for name, shape in self.shapes.items()}
