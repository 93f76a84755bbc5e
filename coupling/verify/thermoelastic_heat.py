"""Heat that motion makes and moves: deformation, pressed joints, friction, sunlight on what turns.

Whole scenes, run through their windows; each by every solver of heat that can express it.
Aluminium here has E = 69 GPa, alpha = 23.1e-6 1/K, k = 167 W/(m K), c = 896 J/(kg K).
"""

from collections.abc import Sequence
from math import asin, cos, cosh, exp, pi, sin, sinh, sqrt
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import simpson, solve_ivp

from coupling.casefile import from_text
from coupling.environments import environment
from coupling.manager import Coupled, Pair
from coupling.model import Model, build
from coupling.overrides import parse
from coupling.simulation import Stopped, windows
from coupling.transfer import transfer
from coupling.verify.heat import ALUMINIUM, bar, conductor, still, suited
from coupling.verify.models import ROOM
from coupling.verify.registry import Check, Convergence, problem
from coupling.verify.sliding import RADIUS as JOURNAL
from coupling.verify.sliding import RATE, SIDES, Sliding
from mechanics.ledger import TERMS
from meshes.solids import box
from thermal import solvers
from thermal.description import Description, Link, Member, Place, Settings, Solid, Source
from thermal.illumination import sky

Array = NDArray[np.float64]

LINES = ("line", "hermite", "wall", "solid", "lumped")
"""Solvers of heat that take tubes and parts, and that motion can give heat to."""
MODULUS, DENSITY, EXPANSION, CONDUCTIVITY, CAPACITY = 69e9, 2700.0, 23.1e-6, 167.0, 896.0
DIFFUSIVITY = CONDUCTIVITY / (DENSITY * CAPACITY)  # [m^2/s]
START = 298.15  # [K]
COOLING = START * EXPANSION / (DENSITY * CAPACITY)  # [K/Pa]
RELAXATION = MODULUS * EXPANSION * COOLING
"""Zener's strength E alpha^2 T/(rho c), (E_S - E_T)/E_S [-]."""
METAL = """
[material.al]
density = 2700
youngs_modulus = "69 GPa"
poissons_ratio = 0.0
expansion = "23.1e-6 1/K"
conductivity = 167
heat_capacity = 896
"""


class Ran(NamedTuple):
    """A scene that was run: times (k + 1,) [s] of its k windows' ends, and the states there."""

    model: Model
    times: Array
    states: Sequence[Coupled]

    def ledger(self, name: str) -> Array:
        """(k + 1,) [J]  a mechanical term."""
        return np.array([float(s.motion.ledger[TERMS.index(name)]) for s in self.states])

    def probe(self, name: str, field: str) -> Array:
        """(k + 1, ...)"""
        return np.array([self.model.probes(s)[name][field] for s in self.states])


def ran(text: str, *settings: str) -> Ran:
    """Run a scene to its end; an error if it stops."""
    model = build(from_text(text, Path(), parse(settings)))
    times, states = [0.0], [model.initial()]
    for window in windows(model, states[0]):
        if isinstance(window, Stopped):
            raise RuntimeError(window.why)
        times.append(window.t)
        states.append(window.state)
    return Ran(model, np.array(times), states)


# -- heat of deformation -----------------------------------------------------------------------

RADIUS, THICKNESS, LENGTH = 2e-3, 1e-4, 0.2  # [m]  of a thin tube
AREA = 2.0 * pi * RADIUS * THICKNESS
STEPS = 60
"""Windows of a period, and a step each."""
PULLED = (
    METAL
    + f"""
[section.s]
kind = "tube"
mean_radius = {RADIUS}
thickness = {THICKNESS}
[body.rod]
kind = "beam"
start = [0, 0, 0]
end = [{LENGTH}, 0, 0]
elements = 4
section = "s"
material = "al"
normal = [0, 1, 0]
[joint.root]
kind = "clamp"
a = {{ body = "rod", at = "start" }}
[load.pull]
kind = "force"
at = {{ body = "rod", at = "end" }}
direction = [1, 0, 0]
amplitude = "1 N"
[thermal]
initial = "{START} K"
tolerance = 1e-6
[thermal.elastic]
bodies = ["rod"]
[probe.tip]
body = "rod"
at = "end"
"""
)
STRETCHED = """
[time]
end = "1 s"
window = "0.1 s"
[integrator]
tolerance = 1e-3
"""
SWINGING = f"""
[integrator]
scheme = "generalised-alpha"
spectral_radius = 0.6
tolerance = 0.1
newton_tolerance = 1e-9
[body.mass]
kind = "particle"
position = [{LENGTH}, 0, 0]
mass = 1
[joint.tip]
kind = "spherical"
a = {{ body = "rod", at = "end" }}
b = {{ body = "mass" }}
"""
WITHOUT = PULLED.replace('[thermal.elastic]\nbodies = ["rod"]\n', "")


@problem("heat", "stretched metal cools", "Joule 1859: T alpha sigma/(rho c) per stress")
def stretched_metal() -> list[Check]:
    """Under 1 MPa, as the temperature itself falls by 0.1 % at 100 MPa."""
    force = f"load.pull.amplitude={{ramp={{end='0.5 s',from=0,to={1e6 * AREA}}}}}"
    checks = []
    for solver in LINES:
        found = ran(
            PULLED + STRETCHED, force, "body.rod.damping='1 ms'", f"thermal.solver='{solver}'"
        )
        cooled = found.model.sections(found.states[-1])[:, 0] - START
        name = f"per 100 MPa, {solver}"
        checks.append(Check(name, 100.0 * float(cooled.mean()), -0.284692, 5e-5, "K"))
        row = found.model.ledger(found.states[-1])
        defect = row["heat_defect"] / row["heat_of_deformation"]
        checks.append(Check(f"defect of balance, {solver}", defect, 0.0, 1e-9, "", True))
    return checks


def _swinging(
    frequency: float, stiffness: float, periods: int, direction: str, strain: float
) -> list[str]:
    """Settings of a mass on the tube that starts under a force, with a step in each window."""
    step = 1.0 / (STEPS * frequency)
    mass = stiffness / (2.0 * pi * frequency) ** 2
    return [
        f"body.mass.mass={mass!r}", f"load.pull.amplitude={stiffness * strain * LENGTH!r}",
        f"load.pull.direction={direction}",
        f"time.end={periods / frequency!r}", f"time.window={step!r}",
        f"integrator.largest_step={step!r}", f"integrator.smallest_step={step!r}",
    ]  # fmt: skip


@problem("heat", "adiabatic and isothermal stiffness", "E_S/E_T = 1/(1 - E alpha^2 T/(rho c))")
def adiabatic_stiffness() -> list[Check]:
    """A mass swings along the tube at 50 Hz, too fast for heat to flow anywhere."""
    reference, axial = RELAXATION / (1.0 - RELAXATION), MODULUS * AREA / LENGTH
    settings = _swinging(50.0, axial, 3, "[1,0,0]", 1e-5)
    isothermal = _frequency(ran(WITHOUT + SWINGING, *settings))
    checks = []
    for solver in LINES:
        adiabatic = _frequency(ran(PULLED + SWINGING, *settings, f"thermal.solver='{solver}'"))
        found = (adiabatic / isothermal) ** 2 - 1.0
        checks.append(Check(f"E_S/E_T - 1, {solver}", found, reference, 1e-2))
    return checks


def _frequency(found: Ran) -> float:
    """[Hz] of a vibration along the tube, by its passages through the mean."""
    t, x = found.times, found.probe("tip", "position")[:, 0]
    x = x - 0.5 * (x.max() + x.min())
    i = np.flatnonzero(np.diff(np.sign(x)))
    passed = t[i] + (t[i + 1] - t[i]) * x[i] / (x[i] - x[i + 1])
    return float(0.5 * (len(passed) - 1) / (passed[-1] - passed[0]))


@problem("heat", "a swinging tube is damped and warms", "Zener 1938; a thin tube: tau = R^2/D")
def zener() -> list[Check]:
    """A mass on the tube's end; heat flows round the tube at w tau = 1, where it damps most.

    The energy that motion loses is the heat that deformation released, but for what comes back.
    """
    checks = []
    for solver in LINES:
        elements = 20 if solver == "hermite" else 8  # which takes heat at its stations, not between
        found = _bent(0.5 * RADIUS**2, AREA, RADIUS**2 / DIFFUSIVITY, f"thermal.solver='{solver}'",
                      f"body.rod.elements={elements}", "thermal.wall_points=8")  # fmt: skip
        checks.append(Check(f"1/Q, {solver}", found[0], 0.5 * RELAXATION, 1e-2))
        checks.append(Check(f"heat/energy lost, {solver}", found[1], 1.0, 2e-2))
    return checks


@problem("heat", "a swinging bar is damped", "Lifshitz & Roukes 2000; two gradients: tau = h^2/12D")
def rectangular_zener() -> list[Check]:
    """At w = 12 D/h^2. A section with two gradients has one time of relaxation, the bar many.

    Of ``solid`` heat is stored at nodes, whose second moment exceeds that of the section.
    """
    height, width = 4e-3, 2e-3
    tau, xi = height**2 / (12.0 * DIFFUSIVITY), sqrt(6.0)
    many = 6.0 / xi**2 - 6.0 / xi**3 * (sinh(xi) + sin(xi)) / (cosh(xi) + cos(xi))
    section = f"section.s={{kind='rectangle',height={height},width={width}}}"
    exact = {"line": 0.5, "hermite": 0.5, "lumped": 0.5, "solid": many}
    checks = []
    for solver, share in exact.items():
        elements = 20 if solver == "hermite" else 8
        allowed = 5e-2 if solver == "solid" else 2e-2
        damping, heat = _bent(
            height**2 / 12.0, height * width, tau, section, f"thermal.solver='{solver}'",
            f"body.rod.elements={elements}", "thermal.full_sections='gradients'",
        )  # fmt: skip
        checks.append(Check(f"1/Q, {solver}", damping, share * RELAXATION, 1e-2))
        checks.append(Check(f"heat/energy lost, {solver}", heat, 1.0, allowed))
    return checks


PERIODS = 3


def _bent(square: float, area: float, tau: float, *settings: str) -> tuple[float, float]:
    """1/Q of the tube swinging sideways at w = 1/tau, and heat over the energy that was lost.

    Both from the second period on. The axial force stores heat too, which comes back.

    square : float [m^2]  of the radius of gyration
    """
    stiffness, strain = 3.0 * MODULUS * area * square / LENGTH**3, 5e-3
    swinging = _swinging(0.5 / (pi * tau), stiffness, PERIODS, "[0,1,0]", strain)
    found = ran(PULLED + SWINGING, *swinging, *settings)
    energy = found.ledger("kinetic") + found.ledger("strain") - found.ledger("work_loads")
    amplitude = energy[STEPS] + 0.5 * stiffness * (strain * LENGTH) ** 2
    lost = -np.diff(found.ledger("work_thermal")[[STEPS, -1]])[0]
    heat = [
        s.elastic + EXPANSION * START * LENGTH * _axial(found.model, s)
        for s in (found.states[STEPS], found.states[-1])
    ]
    damping = -np.log1p(-lost / amplitude) / (2.0 * pi * (PERIODS - 1))
    return float(damping), float((heat[1] - heat[0]) / lost)


def _axial(model: Model, state: Coupled) -> float:
    """Mean axial force [N] of the rod."""
    return float(model.bodies(state)["rod"]["resultants"][:, 0].mean())


# -- heat through joints -----------------------------------------------------------------------

PRESSED = (
    METAL
    + """
[time]
end = "20 s"
window = "1 s"
[integrator]
tolerance = 1e-6
[body.bar]
kind = "rigid"
position = [0, -4.9999e-5, 0]
mass = "2 kg"
inertia = [1, 1, 1]
[joint.pin]
kind = "clearance_revolute"
journal = { body = "bar" }
bearing = { body = "ground", position = [0, 0, 0] }
axis = [0, 0, 1]
radius = "10 mm"
clearance = "50 um"
journal_material = "al"
bearing_material = "al"
contact = { restitution = 0.5, stiffness = "linear", value = "1e6 N/m" }
[load.down]
kind = "force"
at = { body = "bar" }
direction = [0, -1, 0]
amplitude = "20 N"
[thermal]
initial = "300 K"
tolerance = 1e-6
[thermal.part.pin]
of = "pin.journal"
material = "al"
mass = "0.1 kg"
initial = "350 K"
[thermal.part.bush]
of = "pin.bearing"
material = "al"
mass = "0.1 kg"
"""
)
BY_FORCE = """
[thermal.contact.touch]
joint = "pin"
by_force = [["0 N", "0 W/K"], ["1000 N", "100 W/K"]]
"""
ROUGH = """
[thermal.contact.touch]
joint = "pin"
roughness = "1 um"
slope = 0.1
hardness = "1.1 GPa"
area = "5 cm^2"
"""
PER_FORCE = 0.1  # [W/(K N)]
PART = 0.1 * CAPACITY  # [J/K]


@problem("heat", "a pressed pin", "exp(-2 G t/C); Cooper, Mikic & Yovanovich 1969")
def pressed_pin() -> list[Check]:
    """20 N at rest between two equal parts: 2 W/K by a table, then by rough surfaces."""
    rough = 1.25 * CONDUCTIVITY * 0.1 / 1e-6 * 5e-4 * (20.0 / 5e-4 / 1.1e9) ** 0.95
    checks = []
    for name, table, G in (("by force", BY_FORCE, 20.0 * PER_FORCE), ("rough", ROUGH, rough)):
        found = ran(PRESSED + table)
        T, exact = found.states[-1].T, 50.0 * exp(-2.0 * G * 20.0 / PART)
        conductance = float(found.states[-1].outside["contact.touch"][0])
        checks.append(Check(f"conductance, {name}", conductance, G, 1e-6, "W/K"))
        checks.append(Check(f"difference after 20 s, {name}", float(T[0] - T[1]), exact, 1e-5, "K"))
    return checks


MOUNT = """
[thermal.link.mount]
a = { part = "bush" }
temperature = "300 K"
conductance = "1 W/K"
"""


@problem("heat", "a pin that chatters", "mean of |F| of a slow load; no matter which windows")
def chattering_pin() -> list[Check]:
    """20 N + 60 N at 0.5 Hz throw the pin from side to side of its bearing."""
    a, b = 20.0, 60.0
    mean = PER_FORCE * 2.0 / pi * (a * asin(a / b) + sqrt(b * b - a * a))
    shaken = f"load.down.amplitude={{sine={{amplitude=-{b},period='2 s',offset={a}}}}}"
    checks, ends = [], []
    for count in (20, 200):
        found = ran(PRESSED + BY_FORCE + MOUNT, shaken, "time.end='4 s'",
                    f"time.window={4.0 / count}", "integrator.largest_step='2 ms'")  # fmt: skip
        G = np.array([float(s.outside["contact.touch"][0]) for s in found.states[1:]])
        per_run = float(np.diff(found.times) @ G) / 4.0
        checks.append(Check(f"mean conductance, {count} windows", per_run, mean, 1e-3, "W/K"))
        ends.append(float(found.states[-1].T[0]))
    return [*checks, Check("pin after 4 s", ends[0], ends[1], 2e-3, "K", True)]


@problem("heat", "order of a joint's conductance in the window", "two equations, DOP853")
def conductance_order() -> list[Convergence]:
    """20 N + 15 N at 1/16 Hz; the bearing gives its heat to a mount."""
    slow = "load.down.amplitude={sine={amplitude=15,period='16 s',offset=20}}"
    exact = _by_swaying_force(16.0)
    checks = []
    for scheme, theory, sizes in (
        ("serial", 1.0, (0.5, 0.25, 0.125)), ("corrected", 2.0, (4.0, 2.0, 1.0))
    ):  # fmt: skip
        errors = []
        for window in sizes:
            found = ran(PRESSED + BY_FORCE + MOUNT, slow, "time.end='16 s'",
                        f"time.window={window}", f"coupling.scheme='{scheme}'",
                        "integrator.largest_step='50 ms'")  # fmt: skip
            errors.append(float(np.abs(found.states[-1].T - exact).max()))
        checks.append(Convergence(scheme, sizes, errors, theory, 0.2, "s"))
    return checks


def _by_swaying_force(end: float) -> Array:
    """(2,) [K] of pin and bearing."""

    def rate(t: float, T: Array) -> Array:
        through = PER_FORCE * (20.0 + 15.0 * np.sin(2.0 * pi * t / 16.0)) * (T[0] - T[1])
        return np.array([-through, through - (T[1] - 300.0)]) / PART

    return solve_ivp(rate, (0.0, end), [350.0, 300.0], "DOP853", rtol=1e-12).y[:, -1]


# -- frictional heat ---------------------------------------------------------------------------

STEEL = conductor(16.2, 8000.0, 500.0)


@problem(
    "heat", "two bars heated where they touch", "Carslaw & Jaeger 1959: shares by sqrt(k rho c)"
)
def partition() -> list[Check]:
    """Aluminium and steel, 0.1 s after the heat begins; neither feels its other end."""
    checks = []
    for solver in LINES:
        pair = [
            suited(solver, bar(0.012, 120, 300.0, material=m, name=n))
            for n, m in (("al", ALUMINIUM), ("steel", STEEL))
        ]
        touch = Link("touch", Place("al", "start"), Place("steel", "start"), 1e5)
        heater = Source("heater", Place("al", "start"), still(10.0))
        made = solvers.build(solver, Description(pair, (), (touch,), (heater,)), Settings(1e-4))
        T, _, why = made.advance(made.initial(), 0.0, 0.1, np.zeros(len(made.x)))
        if why:
            raise RuntimeError(why)
        stored = {m.name: _stored(made, T, m) for m in pair}
        share = stored["al"] / sum(stored.values())
        checks.append(Check(f"share of the aluminium, {solver}", share, 0.714035, 2e-3))
    return checks


def _stored(solver: Any, T: Array, m: Member) -> float:
    """Heat [J] that a bar has received, per length of it."""
    mean = solver.space.place(Place(m.name))
    rise = float(mean.weights @ (T[mean.nodes] - 300.0))
    return rise * m.section.area * m.material.density * float(m.material.heat_capacity(300.0))


class Slabs(Sliding):
    """The journal and its bearing as slabs of 10 mm, in 3D, that rub on a face of 10 cm^2."""

    def build(self) -> Pair:
        motion = super().build().motion_solver
        mesh = box((0.01, 0.02, 0.05), (20, 2, 2))
        slabs = [
            Solid(side, mesh, {"": m}, ROOM, rubbing="x0")
            for side, m in zip(SIDES, self.materials, strict=True)
        ]
        solid = solvers.build("solid", Description(solids=slabs), Settings(1e-5))
        shares = {side: solid.space.place(Place(side, "x0")).weights for side in SIDES}
        read = transfer(
            solid.x, solid.regions, motion.x, motion.axes, motion.regions,
            np.full(len(motion.x), ROOM), shares=shares,
        )  # fmt: skip
        return Pair(solid, motion, read)


@problem("heat", "two slabs that rub", "q t/(rho c L), and q L/(3 k) more where they touch")
def rubbing_slabs() -> list[Check]:
    """100 W of friction for 10 s; 3D."""
    speed = RATE * JOURNAL
    slabs = Slabs((ALUMINIUM, ALUMINIUM), (0.027, 0.027), 0.25, 100.0 / (0.25 * speed))
    pair, state = slabs.run("corrected", 10.0, 4)
    solver: Any = pair.heat_solver
    checks = []
    for side in SIDES:
        faces = [solver.space.place(Place(side, face)) for face in ("x0", None)]
        touching, mean = (float(f.weights @ state.T[f.nodes]) - ROOM for f in faces)
        uneven = float(np.ptp(state.T[faces[0].nodes]))
        checks += [
            Check(f"mean rise, {side}", mean, 20.667989, 1e-5, "K"),
            Check(f"rise of the interface, {side}", touching, 21.665993, 1e-4, "K"),
            Check(f"uneven, {side}", uneven, 0.0, 1e-6, "K", True),
        ]
    return checks


WARM = (
    METAL
    + """
[time]
end = "2 s"
window = "0.1 s"
[integrator]
tolerance = 1e-5
[section.s]
kind = "tube"
mean_radius = "20 mm"
thickness = "2 mm"
[body.arm]
kind = "beam"
start = [0, 0, 0]
end = [1, 0, 0]
elements = 2
section = "s"
material = "al"
normal = [0, 1, 0]
damping = "2 ms"
[joint.hinge]
kind = "clearance_revolute"
journal = { body = "arm", at = "start" }
axis = [0, 0, 1]
radius = "10 mm"
clearance = "50 um"
journal_material = "al"
bearing_material = "al"
angle = { s_curve = { rate = "40 deg/s", rise = "0.3 s", total = "70 deg" } }
friction = { coefficient = 0.3 }
[gravity]
acceleration = [0, "-9.81 m/s^2", 0]
[thermal]
initial = "300 K"
[thermal.part.pin]
of = "hinge.journal"
material = "al"
mass = "0.05 kg"
area = "30 cm^2"
[thermal.part.bush]
of = "hinge.bearing"
material = "al"
mass = "0.05 kg"
area = "60 cm^2"
[thermal.contact.touch]
joint = "hinge"
by_force = [["0 N", "0 W/K"], ["100 N", "5 W/K"]]
by_gap = [["0 um", "0.2 W/K"], ["100 um", "0.1 W/K"]]
[thermal.link.fitting]
a = { part = "pin" }
b = { body = "arm", at = "start" }
conductance = "2 W/K"
[thermal.radiation.pin]
part = "pin"
emissivity = 0.8
sink = "3 K"
[thermal.radiation.bush]
part = "bush"
emissivity = 0.8
sink = "3 K"
[thermal.radiation.arm]
body = "arm"
emissivity = 0.8
sink = "3 K"
"""
)


@problem("heat", "friction warms what radiates", "heat stored + radiated = work of friction")
def friction_and_radiation() -> list[Check]:
    """A loose pin, an arm and a bush that lose heat by their areas; the rest is round-off."""
    checks = []
    for solver in LINES:
        found = ran(WARM, f"thermal.solver='{solver}'")
        row, work = found.model.ledger(found.states[-1]), float(found.ledger("friction")[-1])
        gone = [v for name, v in row.items() if name.startswith("heat_radiation")]
        whole = work + abs(sum(gone))
        defect = (row["heat_stored"] - sum(gone) - work) / whole
        checks.append(Check(f"defect over heat, {solver}", defect, 0.0, 1e-11, "", True))
        made = (row["heat_exchanged"] - work) / work
        checks.append(Check(f"heat over work - 1, {solver}", made, 0.0, 1e-11, "", True))
    return checks


# -- sunlight on what turns --------------------------------------------------------------------

TURNING = (
    METAL
    + """
[time]
end = "16 s"
window = "1 s"
[integrator]
tolerance = 1e-4
[section.s]
kind = "tube"
mean_radius = "20 mm"
thickness = "1 mm"
[body.arm]
kind = "beam"
start = [0, 0, 0]
end = [1, 0, 0]
elements = 2
section = "s"
material = "al"
normal = [0, 1, 0]
damping = "5 ms"
[joint.hinge]
kind = "revolute"
a = { body = "arm", at = "start" }
axis = [0, 0, 1]
angle = { ramp = { end = "64 s", from = 0, to = "360 deg" } }
[thermal]
initial = "300 K"
wall_points = 16
tolerance = 1e-5
[thermal.environment]
sun = { direction = [1, 0, 0] }
[thermal.surface.skin]
body = "arm"
absorptivity = 0.8
emissivity = 0.0
"""
)


LIT = 0.8 * 1361.0 * 2.0 * 0.0205  # [W]  absorbed across the light


@problem("heat", "sunlight on a turning tube", "2 R L q |sin|, from along the light to across")
def sunlit_turn() -> list[Check | Convergence]:
    """Heat absorbed over a quarter of a turn, and how its error falls with the window.

    ``lumped`` takes the light at 16 points round, ``solid`` on 24 flat sides.
    """
    exact = LIT * 64.0 / (2.0 * pi)
    checks: list[Check | Convergence] = []
    for solver in LINES:
        found = _lit(TURNING, f"thermal.solver='{solver}'")
        tolerance = {"lumped": 2e-2, "solid": 5e-3}.get(solver, 1.5e-3)
        checks.append(Check(f"absorbed, {solver}", found, exact, tolerance, "J"))
    for scheme, theory in (("serial", 1.0), ("corrected", 2.0)):
        scheme_is, sizes = f"coupling.scheme='{scheme}'", (4.0, 2.0, 1.0)
        absorbed = [_lit(TURNING, scheme_is, f"time.window={w}") for w in sizes]
        errors = np.abs(np.array(absorbed) / exact - 1.0).tolist()
        checks.append(Convergence(scheme, sizes, errors, theory, 0.2, "s"))
    return checks


def _lit(text: str, *settings: str) -> float:
    """Heat [J] of sunlight that a scene has absorbed at its end."""
    found = ran(text, *settings)
    return found.model.ledger(found.states[-1])["heat_light.skin"]


ECLIPSED = (
    TURNING.replace(
        "sun = { direction = [1, 0, 0] }",
        """sun = { beta = 0 }
orbit = { kind = "circular", altitude = "400 km", phase = "107 deg" }
planet = { albedo = 0, infrared = 0 }""",
    )
    .replace("end = [1, 0, 0]", "end = [0, 0, 1]")
    .replace('angle = { ramp = { end = "64 s", from = 0, to = "360 deg" } }', "angle = 0")
)


@problem("heat", "a tube flies into the shadow", "integral of the sun's visible part, Simpson")
def eclipse_entry() -> list[Check]:
    """The penumbra of 8 s begins and ends within windows of 20 s; then windows of 2 s.

    A window that meets a shadow errs by half of its light at the most.
    """
    whole = LIT * _visible(80.0)
    checks = []
    for window, allowed in ((20.0, 10.0 * LIT), (2.0, 0.05 * LIT)):
        found = _lit(ECLIPSED, f"time.window={window}", "time.end='80 s'")
        checks.append(
            Check(f"absorbed, {window:g} s", found, whole, allowed + 3e-3 * whole, "J", True)
        )
    return checks


def _visible(end: float) -> float:
    """[s]  integral of the visible part of the sun's disc."""
    table = build(from_text(ECLIPSED, Path())).scene.thermal
    assert table is not None and table.environment is not None
    seen, t = environment(table.environment), np.linspace(0.0, end, 2001)
    return float(simpson([sky(seen, x).visible for x in t], x=t))
