"""Sun and planet over time, as they are recorded."""

from typing import Any

from thermal.illumination import Environment, sky


def row(environment: Environment, t: float) -> dict[str, Any]:
    """What is overhead at a time [s], in the coordinates of the case; see ``columns``."""
    now = sky(environment, t)
    return {
        "time": t,
        "sun": now.sun,
        "planet": now.nadir,
        "flux": now.flux,
        "visible": now.visible,
    }
