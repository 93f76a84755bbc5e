"""Other programs as participants, where they are installed and able."""

from coupling.crosscheck.comparison import Measured
from coupling.scene import Scene


def measured_by(name: str, scene: Scene) -> Measured | str:
    """What a program yields, or one sentence why it yields nothing."""
    from coupling.opinion_quantities import told

    found = told(name, scene)
    if not found.quantities:
        return "; ".join(dict.fromkeys(found.why.values()))
    return Measured(name, found.dof, found.quantities, found.seconds, found.why)
