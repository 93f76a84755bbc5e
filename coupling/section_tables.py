"""Tables of the case file about cross-sections of beams and cables."""

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from coupling import quantities
from coupling.fields import PositiveLength, Quantity, Table


class Tube(Table):
    """A circular tube."""

    kind: Literal["tube"]
    mean_radius: PositiveLength = Field(description="radius of the middle of the wall")
    thickness: PositiveLength = Field(description="of the wall")

    def odd_values(self) -> Iterator[tuple[str, str]]:
        if self.thickness >= 2.0 * self.mean_radius:
            yield "thickness", "must be less than twice the mean radius"


class Circle(Table):
    """A solid circle."""

    kind: Literal["circle"]
    radius: PositiveLength = Field(description="a length such as '5 mm'")


class Rectangle(Table):
    """A solid rectangle."""

    kind: Literal["rectangle"]
    height: PositiveLength = Field(description="extent along the normal of the body")
    width: PositiveLength = Field(description="extent across the normal of the body")


SecondMoment = Annotated[float, Quantity(quantities.SECOND_MOMENT, above=0.0)]
ShearFactor = Annotated[float, Quantity(quantities.NUMBER, above=0.0, most=10.0)]


class GeneralSection(Table):
    """A section given by its numbers."""

    kind: Literal["general"]
    area: Annotated[float, Quantity(quantities.AREA, above=0.0)] = Field(
        description="an area such as '5 cm^2'"
    )
    second_moment_2: SecondMoment = Field(description="integral of y^2, y along the normal")
    second_moment_3: SecondMoment = Field(description="integral of z^2, z across the normal")
    torsion_constant: SecondMoment = Field(description="Saint-Venant's, such as '12 cm^4'")
    shear_factor_2: ShearFactor = Field(default=5 / 6, description="along the normal")
    shear_factor_3: ShearFactor = Field(default=5 / 6, description="across the normal")
    outer_perimeter: PositiveLength | None = Field(
        default=None,
        description="what exchanges heat; default: of the rectangle with the same moments",
    )


Section = Tube | Circle | Rectangle | GeneralSection
