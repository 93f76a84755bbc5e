"""The plan: what will run, and what was left out and why."""

from coupling.contact_tables import (
    ClearanceCylindrical,
    ClearanceRevolute,
    ClearanceSpherical,
    ClearanceTranslational,
    Loose,
    Telescope,
)
from coupling.contacts import joint_of
from coupling.descriptions import (
    flexible_bodies,
    line_bodies,
    loose_joints,
    shells,
    sided_joints,
)
from coupling.heat_tables import Thermal
from coupling.scene import Coupling, Scene
from mechanics.schemes import Scheme

KINDS = (
    "wall", "field", "flux", "film", "radiation", "enclosure", "fixed", "source", "part", "solid",
    "link", "interface", "contact", "surface",
)  # fmt: skip
"""Kinds of tables under [thermal]."""
ABSENT = {
    "flux": "fluxes: no [thermal.flux]",
    "radiation": "radiation: no [thermal.radiation]",
    "wall": "prescribed walls: no [thermal.wall]",
    "source": "heat sources: no [thermal.source]",
}


def plan(scene: Scene, system, heat_solver) -> str:
    """Text of the plan.

    Parameters
    ----------
    system : mechanics.system.System
    heat_solver : ThermalSolver or None
    """
    runs = [*_heat_runs(scene, heat_solver), *_motion_runs(scene, system), *_coupling_runs(scene)]
    width = max(len(name) for name, _ in runs)
    lines = [f"{scene.title}", ""] if scene.title else []
    for i, (name, text) in enumerate(runs):
        lines.append(f"{'runs' if i == 0 else '':10}{name:{width}}  {text}")
    for i, text in enumerate(_left_out(scene, system)):
        lines.append(f"{'left out' if i == 0 else '':10}{text}")
    return "\n".join(lines) + "\n"


def _heat_runs(scene: Scene, solver) -> list[tuple[str, str]]:
    table = scene.thermal
    if table is None:
        return []
    conditions = [f"{len(getattr(table, k))} × {k}" for k in KINDS if getattr(table, k)]
    if table.elastic is not None:
        conditions.append(f"heat of deformation in {', '.join(table.elastic.bodies)}")
    what = [f"{len(solver.x)} temperatures"]
    if _tubes(scene):
        what.append(f"{table.wall_points} around a tube")
    if shells(scene) and table.solver != "solid":
        what.append("2 at each node of a shell")
    how = [] if table.solver == "prescribed" else [_steps_of_heat(table)]
    if table.participant is not None:
        how = [f"by '{solver.name}' at {table.participant.address}"]
    text = ", ".join([*what, *conditions, *how])
    unused = getattr(solver, "unused", [])
    runs = [(f"thermal.{table.solver}", text), *_surroundings(table)]
    if unused:
        runs.append(("thermal.unused", f"{', '.join(unused)}: all temperatures are given"))
    return runs


def _surroundings(table: Thermal) -> list[tuple[str, str]]:
    """Sun, orbit and attitude."""
    around = table.environment
    if around is None:
        return []
    place = "far from planets" if around.orbit is None else f"{around.orbit.kind} orbit, eclipses"
    n = len(table.surface)
    text = f"sun and shadows on {n} surface{'s' * (n != 1)}, {place}"
    return [("thermal.environment", f"{text}, {around.attitude.frame} attitude")]


def _steps_of_heat(table: Thermal) -> str:
    scheme: str = (
        "tr-bdf2" if (table.solver, table.scheme) == ("lumped", "sdirk2") else table.scheme
    )
    if table.solver == "calculix":
        scheme = "backward Euler of ccx"
    steps = (
        f"error {table.tolerance:g} K a step"
        if table.steps is None
        else (f"{table.steps} equal steps a window")
    )
    return f"{scheme}, {steps}"


def _tubes(scene: Scene) -> bool:
    return any(scene.section[b.section].kind == "tube" for b in line_bodies(scene).values())


def _motion_runs(scene: Scene, system) -> list[tuple[str, str]]:
    runs = []
    for term in system.elements:
        family = type(term).__module__.split(".")[-1]
        damping = ", Kelvin–Voigt damping" if _damped(scene) else ""
        text = f"{len(term.dofs)} elements{damping}"
        if family == "continuum":
            text = f"{_in_3d(system, term)}{damping}"
        elif family == "floating":
            modes = f"6 static modes and {term.modes.strains.shape[2] - 6} vibrations"
            text = f"{term.names[0]} in a frame, {modes} of {text}"
        runs.append((f"mechanics.{family}", text))
    runs.append(
        ("mechanics.joints", f"{system.m} constraints on {system.n} coordinates" + _driven(system))
    )
    runs += _clearances(scene, system)
    if scene.load or scene.gravity:
        runs.append(
            ("mechanics.loads", f"{len(scene.load)} loads" + (", gravity" if scene.gravity else ""))
        )
    if scene.analysis.kind == "dynamics":
        if scene.analysis.start == "equilibrium":
            runs.append(("mechanics.statics", "equilibrium at t = 0, in which the motion begins"))
        return [*runs, (f"mechanics.{scene.integrator.scheme}", _integration(scene))]
    return [*runs, *_analysis(scene)]


def _in_3d(system, term) -> str:
    """Cells of a kind, and how many nodes the bodies of them have."""
    layout = system.layout
    nodes = sum(len(layout.node_dofs[name]) for name in dict.fromkeys(term.names))
    places = sum(name.partition("@")[0] in term.names for name in layout.bodies if "@" in name)
    return f"{len(term.dofs)} × {term.name}, {nodes} nodes, {places} reference points"


CLEARANCES = {
    "planar revolute": lambda j: isinstance(j, ClearanceRevolute) and j.length is None,
    "revolute": lambda j: isinstance(j, ClearanceRevolute) and j.length is not None,
    "spherical": lambda j: isinstance(j, ClearanceSpherical),
    "cylindrical": lambda j: isinstance(j, ClearanceCylindrical),
    "planar translational": lambda j: isinstance(j, ClearanceTranslational) and j.width is None,
    "translational": lambda j: isinstance(j, ClearanceTranslational) and j.width is not None,
    "telescope": lambda j: isinstance(j, Telescope),
}
"""Kinds of joints with clearance, and which they are."""


def _clearances(scene: Scene, system) -> list[tuple[str, str]]:
    """One phrase for each kind of joint with clearance."""
    runs = []
    lugs = scene.mechanics.lug
    if lugs:
        points = sum(name.rpartition(".point_")[0] in lugs for name in system.contact_names)
        text = f"{len(lugs)} × pin in an elastic bore of {points} points, onsets located"
        runs.append(("mechanics.bore", text))
    loose = {name: j for name, j in loose_joints(scene).items() if name not in lugs}
    for kind, belongs in CLEARANCES.items():
        joints = {name: j for name, j in loose.items() if belongs(j)}
        if joints:
            count = sum(joint_of(name, joints) is not None for name in system.contact_names)
            module = "telescope" if kind == "telescope" else "clearance"
            of = "" if count == len(joints) else f" of {count} contacts"
            name = kind if kind == "telescope" else f"{kind} clearance"
            parts = [f"{len(joints)} × {name}{of}", *_laws(list(joints.values())), "onsets located"]
            parts += ["thermal clearance"] if scene.thermal else []
            sprung = any(isinstance(j, Telescope) and j.preload for j in joints.values())
            parts += ["preloaded pads"] if sprung else []
            runs.append((f"mechanics.{module}", ", ".join(parts)))
    return runs


def _laws(joints: list[Loose]) -> list[str]:
    """Normal laws and friction of some joints, each named once."""
    normal = {f"{j.contact.stiffness}, {j.contact.dissipation} hysteresis" for j in joints}
    rough = [j.friction.law for j in joints if j.friction is not None]
    some = "" if len(rough) == len(joints) else f" in {len(rough)}"
    return [*sorted(normal)] + (
        [f"{' and '.join(sorted({*rough}))} friction{some}"] if rough else []
    )


def _analysis(scene: Scene) -> list[tuple[str, str]]:
    """Equilibrium at load factor 1, and vibrations about it."""
    table = scene.analysis
    text = f"load factor from 0 to 1, first load step 1/{table.steps}"
    if table.arc_length:
        text = f"path by arc length to load factor 1, at most {table.most_points} points"
    runs = [("mechanics.statics", text)]
    if table.kind == "modes":
        runs.append(("mechanics.modes", f"{table.count} modes about the equilibrium"))
    return runs


def _damped(scene: Scene) -> bool:
    return any(body.damping > 0.0 for body in flexible_bodies(scene).values())


def _driven(system) -> str:
    count = len(system.driven)
    return f", {count} driven" if count else ""


def _integration(scene: Scene) -> str:
    i = scene.integrator
    largest = i.largest_step or scene.time.window
    scheme = Scheme(i.scheme) if i.alpha is None else Scheme(i.scheme, i.alpha)
    own = {"hht": f"alpha = {scheme.alpha:g}, "}.get(i.scheme, "")
    if i.scheme == "generalised-alpha":
        radius = scheme.spectral_radius if i.spectral_radius is None else i.spectral_radius
        own = f"spectral radius {radius:g}, "
    return f"{own}steps up to {largest:g} s, local error {i.tolerance:g}"


def _coupling_runs(scene: Scene) -> list[tuple[str, str]]:
    if scene.analysis.kind != "dynamics":
        return []
    windows = f"{scene.time.windows} windows of {scene.time.window:g} s"
    if scene.thermal is None:
        return [("coupling.isothermal", windows)]
    table = scene.coupling
    if table.adaptive is not None:
        limit = f"coefficients change by {table.adaptive.change:g} at most"
        windows = f"windows of up to {scene.time.window:g} s, {limit}"
    return [(f"coupling.{table.scheme}", f"{windows}: {_exchange(table)}")]


def _exchange(table: Coupling) -> str:
    """Who computes first."""
    if table.scheme != "iterated":
        return {
            "serial": "heat, then motion",
            "parallel": "heat and motion, each from what the last window left",
            "corrected": "heat, motion, heat again",
        }[table.scheme]
    kind = table.acceleration or "quasi-newton"
    how = "plain" if kind == "none" else kind
    return f"motion and heat until they agree, {how} iteration"


def _left_out(scene: Scene, system) -> list[str]:
    found = []
    if scene.thermal is None:
        found.append("heat: the scene has no [thermal]")
    else:
        found += [text for key, text in ABSENT.items() if not getattr(scene.thermal, key)]
        found += _undelivered(scene)
    if not system.contacts:
        found.append("contact: no joint has clearance")
    if not scene.load:
        found.append("loads: no [load]")
    if scene.gravity is None:
        found.append("gravity: no [gravity]")
    if not _damped(scene):
        found.append("structural damping: no body has any")
    if scene.coupling.density == "constant":
        found.append("mass matrix refill: density is constant")
    return found


def _undelivered(scene: Scene) -> list[str]:
    """Joints whose frictional heat nothing takes."""
    assert scene.thermal is not None
    taken = {part.of for part in scene.thermal.part.values()}
    sides = [
        f"{name}.{side}"
        for name, joint in sided_joints(scene).items()
        if joint.friction is not None
        for side in ("journal", "bearing")
    ]
    return [f"frictional heat of {s}: no [thermal.part] is of it" for s in sides if s not in taken]
