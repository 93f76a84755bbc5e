"""Cross-sections of beams: area, second moments, torsion, shear, perimeter, outline.

The section lies in the plane of e2 (coordinate y) and e3 (coordinate z) with its centroid at the
origin. Shear factors depend on Poisson's ratio, which each constructor takes.
"""

from dataclasses import dataclass
from math import isfinite, pi, sqrt, tanh

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Section:
    """A cross-section, constant along its member.

    Attributes
    ----------
    kind : "tube", "circle", "rectangle" or "general"
    area : float [m^2]
    second_moment_2 : float [m^4]  integral of y^2: resists bending towards e2
    second_moment_3 : float [m^4]  integral of z^2: resists bending towards e3
    torsion_constant : float [m^4]  Saint-Venant
    shear_factor_2, shear_factor_3 : float  shear force = factor * G * area * mean shear strain
    outer_perimeter : float [m]  of the outer contour, which exchanges heat
    height, width : float [m]  extent along e2 and along e3
    radius : float [m]  mean radius of a tube's wall, radius of a circle, otherwise 0
    thickness : float [m]  wall of a tube, otherwise 0
    """

    kind: str
    area: float
    second_moment_2: float
    second_moment_3: float
    torsion_constant: float
    shear_factor_2: float
    shear_factor_3: float
    outer_perimeter: float
    height: float
    width: float
    radius: float = 0.0
    thickness: float = 0.0

    @property
    def polar_moment(self) -> float:
        """Integral of y^2 + z^2 [m^4]: rotary inertia about the axis."""
        return self.second_moment_2 + self.second_moment_3

    def outline(self, n: int) -> Array:
        """Points of the outer contour, turning from e2 towards e3.

        Round sections start on +e2 and are spaced evenly in angle; others have the four corners
        of the rectangle ``height`` by ``width`` among their points.

        Returns
        -------
        (n, 2) float [m]  y and z
        """
        if self.kind in ("tube", "circle"):
            return _circle_outline(0.5 * self.height, n)
        return _rectangle_outline(self.height, self.width, n)


def tube(mean_radius: float, thickness: float, poissons_ratio: float = 0.3) -> Section:
    """Circular tube of given mean radius [m] and wall thickness [m], of any thickness.

    Exact annulus; shear factor of the hollow circle by Cowper (1966), Table 1.
    """
    _require_positive("tube", mean_radius=mean_radius, thickness=thickness)
    _require_poissons_ratio("tube", poissons_ratio)
    if thickness >= 2.0 * mean_radius:
        raise ValueError(
            f"tube: thickness {thickness:g} m leaves no bore; "
            f"it must be less than twice the mean radius {mean_radius:g} m"
        )
    outer, inner = mean_radius + 0.5 * thickness, mean_radius - 0.5 * thickness
    # pi/4 (Ro^4 - Ri^4) written without cancellation for thin walls
    moment = 0.5 * pi * mean_radius * thickness * (outer**2 + inner**2)
    factor = _cowper_hollow_circle(inner / outer, poissons_ratio)
    return Section(
        kind="tube",
        area=2.0 * pi * mean_radius * thickness,
        second_moment_2=moment,
        second_moment_3=moment,
        torsion_constant=2.0 * moment,
        shear_factor_2=factor,
        shear_factor_3=factor,
        outer_perimeter=2.0 * pi * outer,
        height=2.0 * outer,
        width=2.0 * outer,
        radius=mean_radius,
        thickness=thickness,
    )


def circle(radius: float, poissons_ratio: float = 0.3) -> Section:
    """Solid circle of given radius [m]; shear factor by Cowper (1966), Table 1."""
    _require_positive("circle", radius=radius)
    _require_poissons_ratio("circle", poissons_ratio)
    moment = 0.25 * pi * radius**4
    factor = _cowper_hollow_circle(0.0, poissons_ratio)
    return Section(
        kind="circle",
        area=pi * radius**2,
        second_moment_2=moment,
        second_moment_3=moment,
        torsion_constant=2.0 * moment,
        shear_factor_2=factor,
        shear_factor_3=factor,
        outer_perimeter=2.0 * pi * radius,
        height=2.0 * radius,
        width=2.0 * radius,
        radius=radius,
    )


def rectangle(height: float, width: float, poissons_ratio: float = 0.3) -> Section:
    """Solid rectangle, ``height`` [m] along e2 and ``width`` [m] along e3.

    Shear factor by Cowper (1966), Table 1: the same in both directions.
    """
    _require_positive("rectangle", height=height, width=width)
    _require_poissons_ratio("rectangle", poissons_ratio)
    factor = 10.0 * (1.0 + poissons_ratio) / (12.0 + 11.0 * poissons_ratio)
    return Section(
        kind="rectangle",
        area=height * width,
        second_moment_2=width * height**3 / 12.0,
        second_moment_3=height * width**3 / 12.0,
        torsion_constant=rectangle_torsion_constant(height, width),
        shear_factor_2=factor,
        shear_factor_3=factor,
        outer_perimeter=2.0 * (height + width),
        height=height,
        width=width,
    )


def general(
    area: float,
    second_moment_2: float,
    second_moment_3: float,
    torsion_constant: float,
    shear_factor_2: float = 1.0,
    shear_factor_3: float = 1.0,
    outer_perimeter: float | None = None,
    height: float | None = None,
    width: float | None = None,
) -> Section:
    """Section given by its numbers, principal axes along e2 and e3.

    What is left out of perimeter, height and width is taken from the solid rectangle that has
    the same radii of gyration.
    """
    _require_positive(
        "general section",
        area=area,
        second_moment_2=second_moment_2,
        second_moment_3=second_moment_3,
        torsion_constant=torsion_constant,
        shear_factor_2=shear_factor_2,
        shear_factor_3=shear_factor_3,
    )
    height = sqrt(12.0 * second_moment_2 / area) if height is None else height
    width = sqrt(12.0 * second_moment_3 / area) if width is None else width
    perimeter = 2.0 * (height + width) if outer_perimeter is None else outer_perimeter
    _require_positive("general section", height=height, width=width, outer_perimeter=perimeter)
    return Section(
        kind="general",
        area=area,
        second_moment_2=second_moment_2,
        second_moment_3=second_moment_3,
        torsion_constant=torsion_constant,
        shear_factor_2=shear_factor_2,
        shear_factor_3=shear_factor_3,
        outer_perimeter=perimeter,
        height=height,
        width=width,
    )


def rectangle_torsion_constant(height: float, width: float) -> float:
    """Saint-Venant torsion constant [m^4] of a solid rectangle by its series.

    J = a b^3 [1/3 - 64/pi^5 (b/a) sum_{n odd} tanh(n pi a / 2b) / n^5], a >= b
    (Timoshenko & Goodier 1970, Art. 109).
    """
    a, b = max(height, width), min(height, width)
    # the terms fall as n^-5: after n = 199 the rest is below 1e-10 of the sum
    series = sum(tanh(min(0.5 * n * pi * a / b, 40.0)) / n**5 for n in range(199, 0, -2))
    return a * b**3 * (1.0 / 3.0 - 64.0 / pi**5 * (b / a) * series)


def _cowper_hollow_circle(m: float, nu: float) -> float:
    """Shear factor of a hollow circle, m = inner / outer radius (Cowper 1966, Table 1)."""
    p = (1.0 + m * m) ** 2
    return 6.0 * (1.0 + nu) * p / ((7.0 + 6.0 * nu) * p + (20.0 + 12.0 * nu) * m * m)


def _circle_outline(radius: float, n: int) -> Array:
    if n < 3:
        raise ValueError(f"an outline of a round section needs at least 3 points, got {n}")
    angle = 2.0 * pi * np.arange(n) / n
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def _rectangle_outline(height: float, width: float, n: int) -> Array:
    if n < 4:
        raise ValueError(f"an outline of a section with corners needs at least 4 points, got {n}")
    y, z = 0.5 * height, 0.5 * width
    corners = np.array([[y, -z], [y, z], [-y, z], [-y, -z], [y, -z]])
    sides = [
        np.linspace(corners[k], corners[k + 1], (n + 3 - k) // 4, endpoint=False) for k in range(4)
    ]
    return np.vstack(sides)


def _require_positive(what: str, **numbers: float) -> None:
    for name, number in numbers.items():
        if not (isfinite(number) and number > 0.0):
            raise ValueError(f"{what}: {name} must be positive and finite, got {number!r}")


def _require_poissons_ratio(what: str, nu: float) -> None:
    if not -1.0 < nu <= 0.5:
        raise ValueError(f"{what}: poissons_ratio must be above -1 and at most 0.5, got {nu!r}")
