"""A system as arrays, and the columns and numbers by which compiled code and the rest talk."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mechanics.contact_laws import COLUMNS as COLUMNS  # of responses, which laws of contact fill

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

(ROWS, INTS, FLOATS, COEFS, INT0, FLOAT0, COEF0, ENTRIES, SLOT0, SPREADS, ROLE, CONTACT0,
 CONTACTS) = range(13)  # fmt: skip
"""Columns of ``Program.terms``: sizes, where its data begin, rows and columns of its slots in the
matrix, what it is, its first contact and their number."""
FORCE, TANGENT, ENERGY, RESPOND, REMEMBER = range(5)
"""Columns of ``Program.kernels``: addresses, 0 where there is none."""
BODY, CONSTRAINT, LOAD, CONTACT = range(4)
"""Roles of terms."""
SIZES = 13
KERNELS = 5

(TOLERANCE, LARGEST, SMALLEST, KIND, ALPHA_M, ALPHA_F, BETA, GAMMA, NEWTON, ITERATIONS, FORM,
 RATE) = range(12)  # fmt: skip
"""Entries of the settings."""
NEWMARK, EULER, BDF2 = range(3)
"""Kinds of schemes."""
INDEX3, PROJECTED, BAUMGARTE = range(3)
"""What is demanded of the constraints: positions; velocities, too; a decaying violation."""

DONE, FULL, UNCONVERGED, SINGULAR, INACCURATE, INFINITE, LATCHED, BEYOND = range(8)
"""How a march ends: at the end of the window, rows full, no step possible for one of four
reasons, a latch has caught, or a coordinate of a joint has left its range."""

PATH, PATH_RATE, GAP, DEPTH, DEPTH_RATE, ELASTIC, DISSIPATIVE = 0, 3, 6, 7, 8, 9, 10
FRICTION, SLIP, STUCK, FLAT, PLACE = 11, 14, 17, 18, 19
MOMENT, CENTRE, AXIS, SIDE = 20, 23, 26, 29
"""Columns of the response of a contact: e (3) [m], along which flight is followed, and its rate;
clearance c and penetration [m], its rate [m/s]; elastic and dissipative part of the normal force;
friction on the journal (3) [N]; slip velocity (3) [m/s]; 1 where it sticks; 1 at a plane wall,
where contact is e[0] > c, otherwise |e| > c; place along the bearing [m]; moment of friction about
the centre of the journal (3) [N m], that centre (3) [m], two directions of the journal (3 each),
all along the axes of the bearing, or zeros where they are not known."""

TERMS = 11
(KINETIC, STRAIN, CONTACT_ELASTIC, WORK_LOADS, WORK_DRIVE, WORK_THERMAL, RUBBED, HYSTERESIS,
 DAMPING, NUMERICAL, DEFECT) = range(TERMS)  # fmt: skip
"""Columns of the ledger."""


class Program(NamedTuple):
    """A system as arrays.

    sizes : (5,) int  coordinates n, multipliers m, contacts n_c; 1 where stored energies are
        functions of time, otherwise 0; coordinates for which a number of M stands, 3 or 1
    terms : (n_t, 13) int;  kernels : (n_t, 5) int  addresses
    ints, slots : data of all terms, one after the other
    mass_rows, mass_columns : (n_r + 1,), (n_m,) int  compressed rows of M: one for each vector
        of three coordinates, or for each coordinate; the first column of an entry
    driven : (k,) int  rows of Phi that depend on time
    signals : (k,) int  coefficients that are functions of time;  signal : (1,) int  their address
    contact_at : (n_c,) int  first coefficient of each contact
    latch_at : (n_l, 2) int  coordinate, and the coefficient that says whether it has caught
    limited : (k,) int  coordinates that have a meaning between two values only
    solver : (3,) int  addresses of factor and solve; what a factorisation costs, in corrections
    solver_ints : (k,) int
    floats : data of all terms
    mass : (n_m,) float;  mass_data : (nnz + 1,) float  M on the pattern of the system matrix
    scale : (n,) float  size of each coordinate
    mobility : (n_c, 3, 3) float [1/kg]  inverse of the masses that meet, along the axes of e
    latch_value : (n_l,) float  where it catches
    limits : (k, 2) float  of the limited coordinates
    """

    sizes: Indices
    terms: Indices
    kernels: Indices
    ints: Indices
    slots: Indices
    mass_rows: Indices
    mass_columns: Indices
    driven: Indices
    signals: Indices
    signal: Indices
    contact_at: Indices
    latch_at: Indices
    limited: Indices
    solver: Indices
    solver_ints: Indices
    floats: Array
    mass: Array
    mass_data: Array
    scale: Array
    mobility: Array
    latch_value: Array
    limits: Array


class Packed(NamedTuple):
    """A program in two arrays.

    Functions with many arrays as arguments take long to compile; so all are parts of few.

    places : (k, 2) int  where each field begins and ends, whole numbers first
    """

    places: Indices
    ints: Indices
    reals: Array


(P_SIZES, P_TERMS, P_KERNELS, P_INTS, P_SLOTS, P_MASS_ROWS, P_MASS_COLUMNS, P_DRIVEN, P_SIGNALS,
 P_SIGNAL, P_CONTACT_AT, P_LATCH_AT, P_LIMITED, P_SOLVER, P_SOLVER_INTS, P_FLOATS, P_MASS,
 P_MASS_DATA, P_SCALE, P_MOBILITY, P_LATCH_VALUE, P_LIMITS) = range(22)  # fmt: skip
"""Fields of a packed program."""


def pack(program: Program) -> Packed:
    """The program in two arrays."""
    lines = [np.ascontiguousarray(array).ravel() for array in program]
    places, ends = [], {False: 0, True: 0}
    for line in lines:
        real = line.dtype == np.float64
        places.append((ends[real], ends[real] + line.size))
        ends[real] += line.size
    whole = [line for line in lines if line.dtype != np.float64]
    reals = [line for line in lines if line.dtype == np.float64]
    return Packed(np.array(places, np.int64), np.concatenate(whole), np.concatenate(reals))
