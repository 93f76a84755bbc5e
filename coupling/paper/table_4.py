"""Table 4: whether the three configurations can move as they are said to."""

from collections.abc import Iterator
from math import cos, degrees, pi, sin, sqrt

from coupling.paper.entries import Entry, number
from coupling.paper.workshop import Workshop
from meshes.materials import library_material

BOOM, ARM = 65.5, 63.5
"""Lengths [m]."""
ANGLE = 45.4
"""To which the arm turns, Fig. 17 [deg]."""
MELTING = (582.0, 652.0)
"""Of aluminium 6061 [degC]."""
ABSORPTIVITY, SUN = 1.0, 1361.0
"""Of a black wall [-]; at 1 au [W/m^2]."""


def entries(work: Workshop) -> Iterator[Entry]:
    """Rates against times, gradients, rates of temperature, cost."""
    yield _extension()
    yield _rotation()
    yield _reflector()
    yield _gradient()
    yield from _heating()
    yield _cost()


def _extension() -> Entry:
    rate, time, stroke = 0.1, 720.0, ARM
    shots = [(620.46, 54.2), (715.65, 63.5)]
    dwell = [t - s / rate for t, s in shots]
    return Entry(
        "Table 4",
        "Configuration 1: 0.1 m/s for 720 s",
        "a stroke of 63.5 m",
        f"{rate * time:g} m; the stroke takes {stroke / rate:g} s; the snapshots of Figs. 14 and "
        f"15 begin {dwell[0]:.1f} and {dwell[1]:.1f} s late",
        f"a dwell of {sum(dwell) / 2:.1f} s, then 0.1 m/s (reading)",
        "does not follow, but for a dwell that is not mentioned",
        (63,),
    )


def _rotation() -> Entry:
    rate, time = 0.05, 567.0
    shots = [(28.49, 7.9), (416.43, 41.0), (611.69, 45.4)]
    rates = [
        (b[1] - a[1]) / (b[0] - a[0]) for a, b in zip([(0.0, 0.0), *shots], shots, strict=False)
    ]
    return Entry(
        "Table 4",
        "Configuration 2: 0.05 rad/s for 567 s",
        f"{ANGLE:g} deg",
        f"{degrees(rate * time):.0f} deg, {rate * time / (2 * pi):.1f} turns; mean rates between "
        f"the snapshots of Fig. 17: {', '.join(f'{r:.3f}' for r in rates)} deg/s, and the last is "
        "later than 567 s",
        f"{ANGLE / time:.4f} deg/s; 0.08 deg/s taken, with a smooth start and end (reading)",
        "does not follow: not by rate and time, and the snapshots are not of constant speed",
        (64,),
    )


def _reflector() -> Entry:
    rate, time, radius = 0.01, 6000.0, 50.0
    needed, quick = pi / 2 * 4 / time**2, 2 * sqrt(pi / 2 / rate)
    return Entry(
        "Table 4",
        "Configuration 3: 0.01 rad/s^2 for 6000 s",
        "deployment of the ring",
        f"{0.5 * rate * time**2:.3g} rad, {rate * time:g} rad/s, a rim of {rate * time * radius:g} "
        "m/s",
        f"90 deg there and to rest in 6000 s need {needed:.4g} rad/s^2; with 0.01 rad/s^2 they "
        f"take {quick:.2f} s",
        "does not follow, by four powers of ten",
        (65,),
    )


def _gradient() -> Entry:
    G, alpha = 50.0, float(library_material("al6061-paper").expansion(298.15))
    kappa = alpha * G
    bow = (1 - cos(kappa * BOOM)) / kappa
    return Entry(
        "Table 4",
        "gradient of 50 degC/m from root to tip",
        "50 degC/m along 63.5 m",
        f"{G * ARM:.0f} degC at the tip; aluminium melts at {MELTING[0]:.0f}-{MELTING[1]:.0f} degC",
        f"across the tube: 27 K over 0.54 m and a bow of {bow:.3f} m of the 65.5 m boom "
        f"(sin: {sin(kappa * BOOM) / kappa:.3f} m along), near the 2.5 m of Table 7 (reading)",
        "does not follow: impossible along the arm",
        (38, 79),
    )


def _heating() -> Iterator[Entry]:
    metal = library_material("al6061-paper")
    for place, rate, T in (("Configuration 1", 15.0, 248.15), ("Configuration 3", 25.0, 473.15)):
        per_area = metal.density * float(metal.heat_capacity(T)) * 1e-3
        fastest = ABSORPTIVITY * SUN / per_area
        wall = ABSORPTIVITY * SUN / (per_area * rate) * 1e-3
        cooling = 5.670374419e-8 * T**4 / per_area
        yield Entry(
            "Table 4",
            f"{place}: {rate:g} degC/s at shadow entry or exit",
            f"{rate:g} degC/s",
            f"sunlight, all absorbed, heats 1 mm of aluminium by {fastest:.2f} K/s, and it cools "
            f"by {cooling:.2f} K/s at {T - 273.15:.0f} degC when black; {rate:g} K/s asks for a "
            f"wall of {1e6 * wall:.0f} um",
            "prescribed as printed in the case; sunlight and shadow of an orbit are a case of "
            "their own (sunlit_tube)",
            "does not follow from sunlight",
            (37, 40),
        )


def _cost() -> Entry:
    hours, window = 12.8, 10.0
    days = {name: hours / window * t / 24 for name, t in (("1", 720), ("2", 567), ("3", 6000))}
    shown = ", ".join(f"{d:.0f} d for Configuration {name}" for name, d in days.items())
    shock = 150.0 / 15.0, 250.0 / 25.0
    return Entry(
        "Sec. 4.1, Table 3",
        "12.8 h for each deployment of 10 s, 16 cores",
        "12.8 h",
        f"{shown}; both shocks last {number(shock[0], 's')} and {number(shock[1], 's')}",
        "whole deployments are run here: times with Configurations 1 to 3",
        "does not follow that whole deployments were run; windows of 10 s probably were",
    )
