"""Other programs as participants, where they are installed and able."""

from coupling.crosscheck.comparison import Measured
from coupling.scene import Scene


def measured_by(name: str, scene: Scene) -> Measured | str:
    """What a program yields, or one sentence why it yields nothing."""
    return "is not connected"
