"""Tables of the case file under [mechanics]: beams, or solids in 3D in their place."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from coupling import quantities
from coupling.fields import Count, PositiveLength, Quantity, Table

Element = Literal["hexahedron20", "hexahedron20-full", "hexahedron27"]
Along = Annotated[int, Count(most=1000)]
Round = Annotated[int, Count(least=4, most=360)]
Layers = Annotated[int, Count(most=100)]

CELLS = "of the heat by 'solid', else"


class MeshNumbers(Table):
    """[mechanics.mesh.BODY]: what differs for one body."""

    element: Element | None = Field(default=None, description="default: that of [mechanics]")
    along: Along | None = Field(default=None, description="cells from node to node of the beam")
    round: Round | None = Field(default=None, description="cells round the section")
    layers: Layers | None = Field(
        default=None, description="cells through a wall, from core to surface, each way"
    )


class Lug(Table):
    """[mechanics.lug.JOINT]: the bore of a clearance_revolute joint as an elastic ring.

    Its outer surface is held by the side of the bearing, its inner one is touched by the pin.
    """

    outer_radius: PositiveLength = Field(description="of the ring")
    length: PositiveLength = Field(description="along the axis of the joint")
    round: Annotated[int, Count(least=8, most=720)] = Field(
        default=32, description="cells round the bore"
    )
    layers: Layers = Field(default=3, description="cells from the bore to the outer radius")
    cells: Layers = Field(default=1, description="cells along the axis")
    stiffness: Annotated[float, Quantity(quantities.SURFACE_STIFFNESS, above=0.0)] | None = Field(
        default=None,
        description="penalty: pressure over penetration; default: 10 x Young's modulus over the "
        "size of a cell",
    )


class MechanicsTable(Table):
    """[mechanics]: how beams are computed; all but ``solver`` belongs to the continuum."""

    solver: Literal["ancf", "continuum"] = Field(
        default="ancf",
        description="ancf: elements of beams and shells; continuum: beams as solids in 3D, for "
        "comparison",
    )
    element: Element | None = Field(
        default=None,
        description="of the continuum: quadratic cells of 20 nodes (default, reduced quadrature; "
        "-full) or 27",
    )
    along: Along | None = Field(
        default=None, description=f"cells from node to node of a beam; default: {CELLS} 1"
    )
    round: Round | None = Field(
        default=None, description=f"cells round a section; default: {CELLS} 16"
    )
    layers: Layers | None = Field(
        default=None,
        description="cells through the wall of a tube, from core to surface of a circle, each way "
        f"in a rectangle; default: {CELLS} 1",
    )
    mesh: dict[str, MeshNumbers] = Field(
        default_factory=dict, description="[mechanics.mesh.BODY]: numbers of one body"
    )
    lug: dict[str, Lug] = Field(
        default_factory=dict, description="[mechanics.lug.JOINT]: an elastic bore"
    )

    @property
    def is_continuum(self) -> bool:
        """Whether beams are solids."""
        return self.solver == "continuum"

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if "solver" not in keys:
            for key in sorted(keys & cls.model_fields.keys()):
                yield key, "belongs to solver = 'continuum', and the solver is 'ancf'"

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if not self.is_continuum:
            for key in sorted(self.model_fields_set - {"solver"}):
                yield key, "belongs to solver = 'continuum', and the solver is 'ancf'"
