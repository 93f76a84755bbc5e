"""Where the mechanical energy went; ``mechanics.march`` adds to it step by step.

Works are trapezoidal: the mean of the force at both ends of a step times the increment of its
coordinates. What a scheme itself adds or takes is computed from the forces by its own relations,
the change of kinetic energy from the velocities; what remains between the two is the ``defect``,
which measures the convergence of Newton and round-off. What the forces do by the trapezoidal rule
beyond the change of their potentials and the works listed is ``numerical`` as well.
"""

TERMS = (
    "kinetic", "strain", "contact_elastic",
    "work_loads", "work_drive", "work_thermal",
    "friction", "hysteresis", "damping", "numerical", "defect",
)  # fmt: skip
"""Stored energies, works done on the system, losses (positive), and what is unexplained [J]."""
