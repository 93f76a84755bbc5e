"""Compiled time stepping: everything between two looks at the clock.

One step: predict, correct with a frozen Jacobian until the corrections are small (``steps``),
refuse it or locate the onset of an impact inside (``events``), accept it, book the energy
(``balance``), choose the next size (``contacts``). The terms of the scene are called by address
(``mechanics.kernels``), so that these files are compiled once.

All schemes make q1 = q^ + B a1, v1 = v^ + G a1 from the accelerations at the end of the step, and

    M ((1 - alpha_m) a1 + alpha_m a0) + (1 - alpha_f) F1 + alpha_f F0 = 0,   Phi(q1, t1) = 0

with F all forces but inertia, constraints included. Newmark (1959): B = beta h^2, G = gamma h.
HHT-alpha (Hilber, Hughes & Taylor 1977) has alpha_m = 0, alpha_f = -alpha; generalised-alpha
(Chung & Hulbert 1993) for constrained systems (Arnold & Bruls 2007) has both: their auxiliary
accelerations are a, with F0 and F1 in balance with the true ones. BDF2 (variable steps; Hairer,
Norsett & Wanner 1993, III.5) and backward Euler take q^, v^ from earlier steps and have none.
The multipliers are scaled by (1 - alpha_f) B (Bottasso, Bauchau & Cardona 2007).
"""

from mechanics.march.contacts import (
    CALM,
    IMPACT_RESOLUTION,
    IMPACT_TOLERANCE,
    LANDING,
    LEAST_RESOLUTION,
    note_approach,
)
from mechanics.march.events import locating
from mechanics.march.loop import march, memory, take
from mechanics.march.program import (
    BAUMGARTE,
    BDF2,
    BEYOND,
    BODY,
    COEF0,
    COEFS,
    COLUMNS,
    CONSTRAINT,
    CONTACT,
    CONTACT_ELASTIC,
    CONTACTS,
    DEFECT,
    DEPTH,
    DEPTH_RATE,
    DISSIPATIVE,
    DONE,
    ELASTIC,
    EULER,
    FLAT,
    FRICTION,
    FULL,
    GAP,
    HYSTERESIS,
    INACCURATE,
    INDEX3,
    INFINITE,
    KERNELS,
    KINETIC,
    LATCHED,
    LOAD,
    NEWMARK,
    NUMERICAL,
    PATH,
    PATH_RATE,
    PLACE,
    PROJECTED,
    ROWS,
    RUBBED,
    SINGULAR,
    SIZES,
    SLIP,
    STRAIN,
    STUCK,
    TERMS,
    UNCONVERGED,
    WORK_LOADS,
    Packed,
    Program,
    pack,
)
from mechanics.march.steps import attempt
from mechanics.march.store import (
    APPROACH0,
    BEFORE,
    CLOCK,
    FORCE0,
    HISTORY0,
    LEDGER,
    LOST,
    ROW_APPROACH,
    ROW_DRIVE,
    ROW_LEDGER,
    ROW_LOST,
    ROW_RESPONSE,
    ROW_T,
    ROW_V,
    ROW_Y,
    A,
    Carried,
    Memory,
    Rows,
    V,
    Window,
    Y,
    field,
)
from mechanics.march.terms import energies, forces, half_product, inertia, instant, matrix, respond

__all__ = [
    "APPROACH0", "BAUMGARTE", "BDF2", "BEFORE", "BEYOND", "BODY", "CALM", "CLOCK", "COEF0",
    "COEFS", "COLUMNS", "CONSTRAINT", "CONTACT", "CONTACTS", "CONTACT_ELASTIC", "DEFECT", "DEPTH",
    "DEPTH_RATE", "DISSIPATIVE", "DONE", "ELASTIC", "EULER", "FLAT", "FORCE0", "FRICTION", "FULL",
    "GAP", "HISTORY0", "HYSTERESIS", "IMPACT_RESOLUTION", "IMPACT_TOLERANCE", "INACCURATE",
    "INDEX3", "INFINITE", "KERNELS", "KINETIC", "LANDING", "LATCHED", "LEAST_RESOLUTION", "LEDGER",
    "LOAD", "LOST", "NEWMARK", "NUMERICAL", "PATH", "PATH_RATE", "PLACE", "PROJECTED", "ROWS",
    "ROW_APPROACH", "ROW_DRIVE", "ROW_LEDGER", "ROW_LOST", "ROW_RESPONSE", "ROW_T", "ROW_V",
    "ROW_Y", "RUBBED", "SINGULAR", "SIZES", "SLIP", "STRAIN", "STUCK", "TERMS", "UNCONVERGED",
    "WORK_LOADS", "A", "Carried", "Memory", "Packed", "Program", "Rows", "V", "Window", "Y",
    "attempt", "energies", "field", "forces", "half_product", "inertia", "instant", "locating",
    "march", "matrix", "memory", "note_approach", "pack", "respond", "take",
]  # fmt: skip
