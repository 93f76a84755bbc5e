"""The same scene as a CalculiX deck (Dhondt 2004): a 3D continuum with heat, in one file.

Bodies become quadratic bricks, joints linear equations, loads nodal forces; materials follow the
temperature by tables. Temperatures are given at the nodes. What cannot be written is refused by
name, nothing is left out in silence.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

import mechanics.description as motion
from coupling.deck_bodies import KINDS, Fineness, Meshed, Section, meshed, section_of, temperatures
from coupling.deck_ties import (
    Equations,
    equations,
    groups,
    pulls,
    refusals,
    rows_of,
    shares,
    sides_of,
)
from coupling.descriptions import motion_description
from coupling.errors import BadCase, Problem
from coupling.mechanics_tables import MechanicsTable
from coupling.places import place_of
from coupling.scene import Scene
from mechanics.description import Beam, Description, Shell, Site
from meshes.materials import Material, Property
from thermal.calculix_deck import (
    Series,
    Table,
    amplitudes_text,
    loads_text,
    rows,
    series,
    table,
    tabled,
    wrapped,
)

Array = NDArray[np.float64]

ENTRIES = 65  # temperatures at which a curved secant expansion is given
SPARE = 5.0  # [K] by which tables reach beyond the temperatures of the run
INCREMENTS = 1_000_000
FIRST = 4  # parts of the load with which statics of large rotations begins, unless asked for
STEPS = 200  # equal increments of a motion in time, where none are asked for
ALPHA = -0.05  # numerical damping of the alpha method, CalculiX's own default
SAME = 1e-7  # of the size of a body: points this near are one
SMALLEST_TEMPERATURE_CHANGE = 1e-9  # [K] below which a body counts as unheated
DENSE = 1e-3  # of the range of temperature: steps of a secant's table near its zero
WEAK = (
    "CalculiX 2.20 strains heated material wrongly as it turns: its thermal strain is not "
    "objective, and a heated block that turns by 30 deg shows stress; do not trust it there"
)
"""What a deck with both heat and large rotations says of itself."""


SWOLLEN = (
    "about a heated equilibrium CalculiX multiplies frequencies by the thermal stretch; a body "
    "that has swollen freely vibrates faster by the square root of it"
)
"""What it does to frequencies of a heated body."""


class History(NamedTuple):
    """Section temperatures of bodies at times, or at load factors 0 and 1 in statics.

    times : (k,) float [s];  sections : name -> (k, points, 3) [K], [K/m]
    points : name -> (p, 3) [m];  values : name -> (k, p) [K] at points in three dimensions, which
        count where all nodes of the cells are among them
    """

    times: Array
    sections: Mapping[str, Array]
    points: Mapping[str, Array] = {}
    values: Mapping[str, Array] = {}


class Options(NamedTuple):
    """How a deck is made.

    fineness : of the cells
    large : geometric nonlinearity; None: in statics and dynamics, and before modes with loads; not
        before those of a body that is only heated, since Green's strain makes one that has swollen
        stiffer by the square of its stretch
    steps : equal increments of a motion in time, or increments that statics begins with
    moment : of the loads in statics, as a load factor, or a time [s]
    preload : whether modes are about equilibrium; otherwise of the body as it is at the start, with
        the stiffness of its temperatures
    """

    fineness: Fineness = Fineness()
    large: bool | None = None
    steps: int | None = None
    moment: float = 1.0
    preload: bool = True


DEFAULT = Options()


class Deck(NamedTuple):
    """A deck and what is needed to read its results.

    text : str;  n : nodes;  cells : elements
    probes : name -> section whose mean displacement is the probe's, and its offset (3,)
    held : nodes (k,) that joints hold
    carried : (3,) float [N]  loads at these nodes in statics, which CalculiX adds to reactions
    temperatures : probe -> mean [K] of its section at the end
    warnings : what to mistrust
    """

    text: str
    n: int
    cells: int
    bodies: Mapping[str, Meshed]
    probes: Mapping[str, tuple[Section, Array]]
    held: NDArray[np.intp]
    carried: Array
    temperatures: Mapping[str, float]
    warnings: Sequence[str]


def deck(scene: Scene, heat: History, options: Options = DEFAULT) -> Deck:
    """The deck of a scene.

    Parameters
    ----------
    heat : temperatures; see ``coupling.deck_heat``

    Raises
    ------
    BadCase : with one sentence for everything that is not written
    """
    scene = beams_of(scene)
    d = motion_description(scene)
    if options.large is None:
        bent = bool(scene.load) or scene.gravity is not None
        options = options._replace(large=scene.analysis.kind != "modes" or bent)
    problems = [*_bodies_refused(d), *refusals(d, bool(options.large)), *_of_scene(scene, d)]
    if problems:
        found = [Problem("", f"not in a CalculiX deck: {p}") for p in problems]
        if any("small rotations" in p for p in problems):
            found.append(Problem("", "--linear writes what is right for small rotations"))
        raise BadCase(str(scene.folder), found)
    sites = {name: site_of(scene, name) for name in scene.probe}
    bodies = meshed(d, [*_sites(d), *sites.values()], options.fineness)
    return _Writer(scene, d, bodies, heat, options, sites).deck()


def beams_of(scene: Scene) -> Scene:
    """The scene with beams in place of solids of our own."""
    return scene.model_copy(update={"mechanics": MechanicsTable()})


def fineness_of(scene: Scene) -> Fineness:
    """Cells as [mechanics] asks for them."""
    table, own = scene.mechanics, Fineness()
    return own._replace(
        around=table.round or own.around,
        layers=table.layers or own.layers,
        refine=table.along or own.refine,
    )


def site_of(scene: Scene, probe: str) -> Site:
    """The material point of a probe."""
    table = scene.probe[probe]
    node, fraction, offset = place_of(scene.shapes[table.body], table)
    return Site(table.body, node, fraction=fraction, offset=offset)


def _sites(d: Description) -> Iterator[Site]:
    for joint in d.joints:
        yield from sides_of(joint)
    for load in d.loads:
        if isinstance(load, motion.Force | motion.Moment):
            yield load.site


def _bodies_refused(d: Description) -> Iterator[str]:
    for body in d.bodies:
        if isinstance(body, Beam):
            if body.element == "cable":
                yield f"body '{body.name}': a cable has no bending stiffness, bricks have"
            elif body.section.kind not in ("tube", "circle", "rectangle"):
                yield f"body '{body.name}': a section of kind '{body.section.kind}' has no shape"
        elif not isinstance(body, Shell):
            kind = "particle" if isinstance(body, motion.Particle) else "rigid body"
            yield f"body '{body.name}': a {kind} is no continuum"


def _of_scene(scene: Scene, d: Description) -> Iterator[str]:
    if scene.damping is not None:
        yield "damping: Rayleigh's of the reference; give [body.NAME] damping instead"
    if d.heavy_when_cold:
        yield "coupling.density: CalculiX keeps the mass of the start"
    if scene.analysis.arc_length:
        yield "analysis.arc_length: CalculiX follows the load only"
    for name, probe in scene.probe.items():
        offset = (
            place_of(scene.shapes[probe.body], probe).offset if _flexible(scene, d, name) else 0
        )
        if np.any(np.asarray(offset)[..., :1]):
            yield f"probe '{name}': it lies off its section"


def _flexible(scene: Scene, d: Description, probe: str) -> bool:
    names = {b.name for b in d.bodies if isinstance(b, Beam | Shell)}
    return scene.probe[probe].body in names


# ------------------------------------------------------------------------------------- text


def _number(value: float) -> str:
    return f"{value:.13e}"


class _Writer:
    """Writes one deck."""

    def __init__(
        self, scene: Scene, d: Description, bodies: Mapping[str, Meshed], heat: History,
        options: Options, sites: Mapping[str, Site],
    ) -> None:  # fmt: skip
        self.scene, self.d, self.bodies, self.options = scene, d, bodies, options
        self.kind = scene.analysis.kind
        self.times = heat.times
        self.T = {name: _nodal(m, name, heat) for name, m in bodies.items()}
        every = np.concatenate([T.ravel() for T in self.T.values()])
        zeros = [m.body.reference_temperature for m in bodies.values()]
        self.span = (
            min(float(every.min()), *zeros) - SPARE,
            max(float(every.max()), *zeros) + SPARE,
        )
        self.heated = any(
            np.abs(T - bodies[name].body.reference_temperature).max() > SMALLEST_TEMPERATURE_CHANGE
            for name, T in self.T.items()
        )
        self.probes = {
            name: (section_of(bodies, site), np.asarray(site.offset))
            for name, site in sites.items()
        }
        self.n = sum(len(m.points) for m in bodies.values())
        self.pulls = pulls(d, bodies)
        self.rows = rows_of(d, bodies)

    def deck(self) -> Deck:
        lines = [*self._head(), *self._mesh(), *self._equations(), *self._sets(), *self._start()]
        lines += self._steps()
        cells = sum(len(m.cells) for m in self.bodies.values())
        text = "\n".join([*lines, ""])
        held, carried, seen = self._held(), self._carried(), self._seen()
        return Deck(
            text, self.n, cells, self.bodies, self.probes, held, carried, seen, self._warnings()
        )

    def _carried(self) -> Array:
        """(3,) [N]  loads at the nodes that joints hold, in statics."""
        held, pulled = self._held(), self._forces(np.array([self.options.moment]))
        total = pulled.reshape(self.n, 3)[held].sum(axis=0)
        if np.any(self.d.gravity):
            masses = [m.body.material.density * shares(m) for m in self.bodies.values()]
            total = total + np.concatenate(masses)[held].sum() * np.asarray(self.d.gravity)
        return total

    def _seen(self) -> dict[str, float]:
        """Mean temperature [K] of the section of each probe at the end."""
        last = np.concatenate([self.T[name][-1] for name in self.bodies])
        return {name: float(s.place @ last[s.nodes]) for name, (s, _) in self.probes.items()}

    def _warnings(self) -> list[str]:
        if not self.heated:
            return []
        if self.kind == "modes":
            return [SWOLLEN] if self.options.preload else []
        return [WEAK] if self.options.large else []

    def _head(self) -> Iterator[str]:
        yield f"** {self.scene.title or 'a case'}".splitlines()[0]
        yield f"** Units: m, kg, s, N, Pa, K. Analysis: {self.kind}."
        yield "** Joints are linear equations between nodes, on the means of sections, which may"
        yield "** breathe; loads are consistent nodal forces that keep their directions."
        yield "** Temperatures are given at the nodes; strain is secant expansion from each ZERO."
        if self.scene.thermal is not None:
            yield "** Left out: heat conduction, radiation and light; their results are given."
        if self.kind == "modes" and not self.options.preload:
            yield "** Left out: loads, and thermal strain; stiffness is that of the temperatures."
        for warning in self._warnings():
            yield f"** Warning: {warning}."

    def _mesh(self) -> Iterator[str]:
        element = 1
        for i, m in enumerate(self.bodies.values()):
            body = m.body
            yield f"** body {body.name}"
            yield f"*NODE,NSET=N{i}"
            yield from rows(m.first + np.arange(1, len(m.points) + 1), m.points)
            yield f"*ELEMENT,TYPE={KINDS[m.family]},ELSET=E{i}"
            for number, nodes in enumerate((m.cells + m.first + 1).tolist(), element):
                yield from wrapped([number, *nodes], 15)
            element += len(m.cells)
            yield from _material(f"M{i}", body, self.span)
            yield f"*SOLID SECTION,ELSET=E{i},MATERIAL=M{i}"

    def _equations(self) -> Iterator[str]:
        for group in groups(self.rows):
            yield from self._solved(equations(group))

    @staticmethod
    def _solved(found: Equations) -> Iterator[str]:
        for k, first in enumerate(found.dependent.tolist()):
            used = np.flatnonzero(found.factors[k])
            terms = [(first, 1.0)]
            terms += list(zip(found.others[used].tolist(), found.factors[k, used], strict=True))
            yield "*EQUATION"
            yield str(len(terms))
            cells = [f"{f // 3 + 1},{f % 3 + 1},{_number(w)}" for f, w in terms]
            yield from (",".join(cells[i : i + 4]) for i in range(0, len(cells), 4))

    def _held(self) -> NDArray[np.intp]:
        nodes = [np.empty(0, np.intp), *(row.nodes for row in self.rows)]
        return np.unique(np.concatenate(nodes))

    def _sets(self) -> Iterator[str]:
        yield "*NSET,NSET=NALL"
        yield from (f"N{i}," for i in range(len(self.bodies)))
        yield "*ELSET,ELSET=EALL"
        yield from (f"E{i}," for i in range(len(self.bodies)))
        seen = [section.nodes for section, _ in self.probes.values()]
        if seen:
            yield "*NSET,NSET=PROBES"
            yield from wrapped((np.unique(np.concatenate(seen)) + 1).tolist(), 15, last=True)
        if len(self._held()):
            yield "*NSET,NSET=HELD"
            yield from wrapped((self._held() + 1).tolist(), 15, last=True)

    def _start(self) -> Iterator[str]:
        yield "** CalculiX counts thermal strain from the initial temperatures: there is none there"
        yield "*INITIAL CONDITIONS,TYPE=TEMPERATURE"
        if self.kind == "modes" and not self.options.preload:
            yield from self._temperatures(-1)
        else:
            yield from (f"N{i},{_number(m.body.reference_temperature)}"
                        for i, m in enumerate(self.bodies.values()))  # fmt: skip
        if self.kind != "dynamics":
            return
        moving = [m for m in self.bodies.values() if np.any(m.body.velocity) or np.any(m.body.spin)]
        if moving:
            yield "*INITIAL CONDITIONS,TYPE=VELOCITY"
        for m in moving:
            v = np.asarray(m.body.velocity) + np.cross(m.body.spin, m.points)
            for node, row in enumerate(v.tolist(), m.first + 1):
                yield from (f"{node},{i},{_number(c)}" for i, c in enumerate(row, 1))

    # -- steps -----------------------------------------------------------------------------

    def _steps(self) -> Iterator[str]:
        if self.kind == "dynamics":
            yield from self._dynamics()
            return
        moment = self.options.moment
        acts = self.heated or any(abs(p.amplitude(moment)) > 0.0 for p in self.pulls)
        acts = (acts or bool(np.any(self.d.gravity))) and self.options.preload
        if self.kind == "statics" or acts:
            yield from self._static(-1, moment)
        if self.kind == "modes":
            yield "*STEP,PERTURBATION" if acts else "*STEP"
            yield "*FREQUENCY"
            yield str(self.scene.analysis.count)
            yield "*NODE FILE"
            yield "U"
            yield from self._volumes()
            yield "*END STEP"

    def _static(self, row: int, moment: float) -> Iterator[str]:
        """Equilibrium with the temperatures of a row of times, and loads of a moment."""
        yield f"*STEP,INC={INCREMENTS}" + (",NLGEOM" if self.options.large else "")
        yield "*STATIC"
        if self.options.large:
            yield f"{_number(1.0 / (self.options.steps or FIRST))},1."
        if self.heated:
            yield "*TEMPERATURE"
            yield from self._temperatures(row)
        forces = self._forces(np.array([moment]))[:, 0]
        if forces.any():
            yield "*CLOAD"
            for f in np.flatnonzero(forces).tolist():
                yield f"{f // 3 + 1},{f % 3 + 1},{_number(forces[f])}"
        yield from self._gravity()
        yield from self._output()
        if self.kind == "dynamics":  # CalculiX wants energies from the first step on
            yield "*EL PRINT,ELSET=EALL,TOTALS=ONLY"
            yield "ELSE"
        yield "*END STEP"

    def _temperatures(self, row: int) -> Iterator[str]:
        for name, m in self.bodies.items():
            yield from rows(m.first + np.arange(1, len(m.points) + 1), self.T[name][row][:, None])

    def _dynamics(self) -> Iterator[str]:
        end = self.scene.time.end
        steps = self.options.steps or STEPS
        heat = self._heat_series()
        samples = np.linspace(0.0, end, steps + 1)
        forces = self._forces(samples)
        used = np.flatnonzero(forces.any(axis=1))
        pulled = series(forces[used])
        if self.scene.analysis.start == "equilibrium":
            yield from self._static(0, 0.0)
        if self.heated:
            yield from amplitudes_text("T", self.times, heat)
        if len(used):
            yield from amplitudes_text("F", samples, pulled)
        yield f"*STEP,INC={INCREMENTS}" + (",NLGEOM" if self.options.large else "")
        yield f"*DYNAMIC,DIRECT,ALPHA={ALPHA}"
        yield f"{_number(end / steps)},{_number(end)}"
        if self.heated:
            yield from loads_text("TEMPERATURE", "T", [str(i + 1) for i in range(self.n)], heat)
        if len(used):
            targets = [f"{f // 3 + 1},{f % 3 + 1}" for f in used.tolist()]
            yield from loads_text("CLOAD", "F", targets, pulled)
        yield from self._gravity()
        yield from self._output()
        yield "*END STEP"

    def _heat_series(self) -> Series:
        return series(np.concatenate([self.T[name].T for name in self.bodies]))

    def _forces(self, moments: Array) -> Array:
        """(3 n, k) [N]"""
        found = np.zeros((self.n, 3, len(moments)))
        for pull in self.pulls:
            amplitude = np.array([pull.amplitude(float(t)) for t in moments])
            np.add.at(found, pull.nodes, pull.forces[..., None] * amplitude)
        return found.reshape(3 * self.n, -1)

    def _gravity(self) -> Iterator[str]:
        size = float(np.linalg.norm(self.d.gravity))
        if size > 0.0:
            down = ",".join(_number(c) for c in (self.d.gravity / size).tolist())
            yield "*DLOAD"
            yield f"EALL,GRAV,{_number(size)},{down}"

    def _output(self) -> Iterator[str]:
        if self.kind != "dynamics":  # fields of every increment would fill a disk
            yield "*NODE FILE"
            yield "U,NT"
            yield "*EL FILE"
            yield "S"
        if self.probes:
            yield "*NODE PRINT,NSET=PROBES"
            yield "U"
        if len(self._held()):
            yield "*NODE PRINT,NSET=HELD,TOTALS=ONLY"
            yield "RF"
        yield from self._volumes()

    def _volumes(self) -> Iterator[str]:
        for i in range(len(self.bodies)):
            yield f"*EL PRINT,ELSET=E{i},TOTALS=ONLY"
            yield "EVOL"


def _nodal(m: Meshed, name: str, heat: History) -> Array:
    """(k, n) [K]"""
    if name in heat.points:
        apart, which = KDTree(heat.points[name]).query(m.points)
        if apart.max() < SAME * np.linalg.norm(np.ptp(m.points, axis=0)):
            return heat.values[name][:, which]
    return np.array([temperatures(m, row) for row in heat.sections[name]])


# -------------------------------------------------------------------------------- materials


def _material(name: str, body: Beam | Shell, span: tuple[float, float]) -> Iterator[str]:
    material: Material = body.material
    yield f"*MATERIAL,NAME={name}"
    yield "*DENSITY"
    yield _number(material.density)
    yield "*ELASTIC"
    yield from tabled(
        (_within(material.youngs_modulus, span), _within(material.poissons_ratio, span))
    )
    yield f"*EXPANSION,ZERO={_number(body.reference_temperature)}"
    yield from tabled((secant(material.expansion, body.reference_temperature, span),))
    yield "*SPECIFIC HEAT"
    yield from tabled((_within(material.heat_capacity, span),))
    kinds = material.conductivities
    alike = len(set(kinds)) == 1
    yield f"*CONDUCTIVITY,TYPE={'ISO' if alike else 'ORTHO'}"
    yield from tabled(tuple(_within(k, span) for k in (kinds[:1] if alike else kinds)))
    if body.damping_time > 0.0:
        yield f"*DAMPING,ALPHA=0.,BETA={_number(body.damping_time)}"


def _within(p: Property, span: tuple[float, float]) -> Table:
    """A property as a table over the temperatures of a run."""
    if p.is_constant:
        return table(p)
    low, high = max(span[0], p.lower), min(span[1], p.upper)
    if not low < high:
        return Table(np.zeros(1), np.array([float(p(low))]))
    return table(replace(p, lower=low, upper=high))


def secant(expansion: Property, zero: float, span: tuple[float, float]) -> Table:
    """Mean expansion [1/K] between ``zero`` [K], where there is no strain, and each temperature."""
    if expansion.is_constant:
        return table(expansion)
    T = np.linspace(*span, ENTRIES)
    T = T[np.abs(T - zero) > DENSE * (span[1] - span[0])]
    values = expansion.integral(zero, T) / (T - zero)
    at = np.searchsorted(T, zero)
    return Table(np.insert(T, at, zero), np.insert(values, at, float(expansion(zero))))
