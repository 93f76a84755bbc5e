"""Tables of the case file about bodies: beams, cables, shells, rigid bodies, particles."""

from collections.abc import Iterator
from math import pi
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from coupling import quantities
from coupling.fields import (
    Axes,
    Count,
    Direction,
    Point,
    PositiveLength,
    PositiveMass,
    Quantity,
    Table,
    Temperature,
    Time,
    Vector,
    Vector3,
)
from coupling.surface_tables import AnySurface

Velocity = Annotated[Vector3, Vector(quantities.SPEED)]
Spin = Annotated[Vector3, Vector(quantities.ANGULAR_SPEED)]
Turn = Annotated[float, Quantity(quantities.ANGLE, least=-2.0 * pi, most=2.0 * pi)]
Distance = Annotated[float, Quantity(quantities.LENGTH, least=0.0)]
Inertia = Annotated[float, Quantity(quantities.INERTIA)]

NORMAL = "of a beam: direction of the section's height; default: any across it"
MATERIAL = "name in the library or of a [material.NAME]"
DAMPING = "Kelvin-Voigt time"
REFERENCE = "free of thermal strain; default: thermal.initial, else 20 degC"
SPIN = "initial rigid rotation about the origin"


class Arc(Table):
    """A circular arc from the start of the body."""

    center: Point = Field(description="a point on the axis of the arc [x, y, z]")
    axis: Direction = Field(description="about which it turns")
    angle: Turn = Field(description="how far it turns, such as '90 deg'")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.angle == 0.0:
            yield "angle", "must not be zero"


class LineBody(Table):
    """A flexible body along a line: straight from start to end, an arc, or a mesh from a file.

    A beam shears, bends and twists; a cable stretches and bends.
    """

    kind: Literal["beam", "cable"]
    start: Point | None = Field(default=None, description="first end [x, y, z]")
    end: Point | None = Field(default=None, description="other end [x, y, z]")
    arc: Arc | None = Field(
        default=None, description="instead of end: {center = ..., axis = ..., angle = ...}"
    )
    elements: Annotated[int, Count()] | None = Field(default=None, description="number of elements")
    nodes: list[Distance] | None = Field(
        default=None,
        description="instead of elements: distances of their ends from the start, from 0 on",
    )
    mesh: str | None = Field(
        default=None, description="file with a line mesh instead, relative to the case folder"
    )
    region: str | None = Field(default=None, description="named region of the mesh file")
    element: Literal["beam3243", "beam3243-continuum", "beam3243-enhanced", "beam3333"] | None = (
        Field(
            default=None,
            description="of a beam; default beam3243, the others are for comparison: 'thermobody "
            "list' says what they are",
        )
    )
    formulation: Literal["floating-frame"] | None = Field(
        default=None,
        description="of a beam: 'floating-frame' is linear elasticity by modes in a frame that "
        "moves with its first section; default: absolute nodal coordinates",
    )
    modes: Annotated[int, Count(least=0)] | None = Field(
        default=None,
        description="of a floating frame: vibrations with both ends held, a multiple of 3, besides "
        "six static modes",
    )
    normal: Direction | None = Field(default=None, description=NORMAL)
    section: str = Field(description="name of a [section.NAME]")
    material: str = Field(description=MATERIAL)
    damping: Time = Field(default=0.0, description=DAMPING)
    reference_temperature: Temperature | None = Field(default=None, description=REFERENCE)
    velocity: Velocity = Field(default=(0.0, 0.0, 0.0), description="initial rigid velocity")
    spin: Spin = Field(default=(0.0, 0.0, 0.0), description=SPIN)

    @property
    def family(self) -> str:
        """Name of its elements in ``mechanics.elements.FAMILIES``."""
        return "cable" if self.kind == "cable" else self.element or "beam3243"

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if "mesh" in keys:
            for key in sorted({"start", "end", "arc", "elements", "nodes"} & keys):
                yield key, "does not go with mesh: give one or the other"
            return
        if "region" in keys:
            yield "region", "belongs to a mesh, and there is none"
        needed = {"start"} | (set() if "nodes" in keys else {"elements"})
        needed |= set() if "arc" in keys else {"end"}
        for key in sorted(needed - keys):
            yield key, f"missing ({cls.model_fields[key].description})"
        for one, other in (("end", "arc"), ("elements", "nodes")):
            if {one, other} <= keys:
                yield other, f"does not go with {one}: give one or the other"

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.kind == "cable":
            for key in ("normal", "element"):
                if getattr(self, key):
                    yield key, "does not go with a cable: it does not twist"
        yield from self._odd_modes()
        if self.nodes is not None:
            yield from self._odd_nodes(self.nodes)
        if self.start and self.end:
            yield from self._odd_line(np.array(self.start), np.array(self.end))
        elif self.start and self.arc:
            radius = np.cross(self.arc.axis, np.subtract(self.start, self.arc.center))
            if np.linalg.norm(radius) <= 1e-12 * max(1.0, *np.abs(self.start)):
                yield "arc.center", "the start of the body lies on the axis of the arc"

    def _odd_modes(self) -> Iterator[tuple[str, str]]:
        if self.formulation is None:
            if self.modes is not None:
                yield "modes", "belongs to formulation = 'floating-frame', and there is none"
        elif self.family != "beam3243":
            word = "cable" if self.kind == "cable" else f"beam of element {self.family}"
            yield "formulation", f"does not go with a {word}: a floating frame takes beam3243"
        elif self.modes is None:
            yield "modes", f"missing ({type(self).model_fields['modes'].description})"
        elif self.modes % 3:
            yield "modes", f"expected a multiple of 3, got {self.modes}"
        elif self.elements is not None and self.modes > 6 * (self.elements - 1):
            most = 6 * (self.elements - 1)
            yield "modes", f"{self.elements} elements have {most} at most, got {self.modes}"

    def _odd_nodes(self, nodes: list[float]) -> Iterator[tuple[str, str]]:
        if len(nodes) < 2 or nodes[0] != 0.0 or (np.diff(nodes) <= 0.0).any():
            yield "nodes", "expected distances that begin with 0 and increase"
        elif self.start and self.end:
            length = float(np.linalg.norm(np.subtract(self.end, self.start)))
            if abs(nodes[-1] - length) > 1e-6 * length:
                yield "nodes", f"must end where the body does, at {length:.9g} m"
        elif self.arc:
            yield "nodes", "does not go with an arc; give elements"

    def _odd_line(self, start: np.ndarray, end: np.ndarray) -> Iterator[tuple[str, str]]:
        along = end - start
        length = np.linalg.norm(along)
        if length <= 1e-12 * max(1.0, *np.abs(start), *np.abs(end)):
            yield "end", "is the same point as start: the body has no length"
        elif self.normal and np.linalg.norm(np.cross(along, self.normal)) <= 1e-6 * length:
            yield "normal", "must not be parallel to the body"


class ShellBody(Table):
    """A flexible surface."""

    kind: Literal["shell"]
    surface: AnySurface = Field(
        description="its middle surface: kind = 'plate', 'tube', 'annulus' or 'sphere'"
    )
    thickness: PositiveLength = Field(description="of the wall")
    element: Literal["shell48", "shell24", "shell3443"] = Field(
        default="shell48",
        description="shell48: thin; shell24: thick; shell3443: fully parametrised, for comparison",
    )
    material: str = Field(description=MATERIAL)
    damping: Time = Field(default=0.0, description=DAMPING)
    reference_temperature: Temperature | None = Field(default=None, description=REFERENCE)
    velocity: Velocity = Field(default=(0.0, 0.0, 0.0), description="initial rigid velocity")
    spin: Spin = Field(default=(0.0, 0.0, 0.0), description=SPIN)


class RigidBody(Table):
    """A rigid body."""

    kind: Literal["rigid"]
    position: Point = Field(description="of its centre of mass at the start [x, y, z]")
    mass: PositiveMass = Field(description="a mass such as '1 kg'")
    inertia: list[Inertia] = Field(
        description="about the centre of mass, along the axes: three principal moments, or six "
        "[xx, yy, zz, yz, xz, xy], or nine"
    )
    axes: Axes = Field(
        default=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        description="directions e1, e2, e3 of the body at the start: two or three [x, y, z]",
    )
    velocity: Velocity = Field(default=(0.0, 0.0, 0.0), description="of the centre of mass")
    spin: Spin = Field(default=(0.0, 0.0, 0.0), description="initial angular velocity")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if len(self.inertia) not in (3, 6, 9):
            yield "inertia", f"expected 3, 6 or 9 numbers, got {len(self.inertia)}"
            return
        matrix = inertia_matrix(self.inertia)
        size = float(np.abs(matrix).max())
        if np.abs(matrix - matrix.T).max() > 1e-9 * size:
            yield "inertia", "the nine numbers are not those of a symmetric matrix"
            return
        least, middle, most = np.linalg.eigvalsh(matrix)
        if least < -1e-9 * size:
            yield "inertia", f"has a negative principal moment, {least:g} kg m^2"
        elif size == 0.0:
            yield "inertia", "is zero: use a particle"
        elif most > (least + middle) * (1.0 + 1e-9) + 1e-12 * size:
            text = f"{most:g} kg m^2, exceeds the sum of the others, {least + middle:g}"
            yield "inertia", f"no body has it: one principal moment, {text}"


def inertia_matrix(numbers: list[float]) -> np.ndarray:
    """(3, 3) [kg m^2] of 3, 6 or 9 numbers."""
    if len(numbers) == 3:
        return np.diag(numbers)
    if len(numbers) == 9:
        return np.reshape(numbers, (3, 3))
    xx, yy, zz, yz, xz, xy = numbers
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


class Particle(Table):
    """A point mass."""

    kind: Literal["particle"]
    position: Point = Field(description="where it is at the start [x, y, z]")
    mass: PositiveMass = Field(description="a mass such as '1 kg'")
    velocity: Velocity = Field(default=(0.0, 0.0, 0.0), description="at the start")


Body = LineBody | ShellBody | RigidBody | Particle


def family_of(body: Body) -> str:
    """Name of its elements, or of its kind of nodes, in ``mechanics.elements.FAMILIES``."""
    if isinstance(body, LineBody):
        return body.family
    return body.element if isinstance(body, ShellBody) else body.kind
