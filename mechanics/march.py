"""Compiled time stepping: everything between two looks at the clock.

One step: predict, correct with a frozen Jacobian until the corrections are small, refuse it or
locate the onset of an impact inside, accept it, book the energy, choose the next size. The terms
of the scene are called by address (``mechanics.kernels``), so that this file is compiled once.

All schemes make q1 = q^ + B a1, v1 = v^ + G a1 from the accelerations at the end of the step, and

    M ((1 - alpha_m) a1 + alpha_m a0) + (1 - alpha_f) F1 + alpha_f F0 = 0,   Phi(q1, t1) = 0

with F all forces but inertia, constraints included. Newmark (1959): B = beta h^2, G = gamma h.
HHT-alpha (Hilber, Hughes & Taylor 1977) has alpha_m = 0, alpha_f = -alpha; generalised-alpha
(Chung & Hulbert 1993) for constrained systems (Arnold & Bruls 2007) has both: their auxiliary
accelerations are a, with F0 and F1 in balance with the true ones. BDF2 (variable steps; Hairer,
Norsett & Wanner 1993, III.5) and backward Euler take q^, v^ from earlier steps and have none.
The multipliers are scaled by (1 - alpha_f) B (Bottasso, Bauchau & Cardona 2007).
"""

from functools import cache
from math import ceil, log2, sqrt
from typing import Any, NamedTuple

import numpy as np
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from mechanics.contact_laws import (
    ACTIVE,
    APPROACH,
    COLUMNS,
    FACTOR,
    HISTORIES,
    HISTORY,
    LUGRE,
    RISING,
    SLOT,
    STEP,
    duration,
    stored,
)
from mechanics.contact_laws import FRICTION as LAW_OF_FRICTION
from mechanics.contact_laws import STICK as STICKING
from mechanics.kernels import (
    at,
    energy_at,
    factor_at,
    force_at,
    kernel,
    remember_at,
    respond_at,
    signals_at,
    solve_at,
    tangent_at,
)

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

(ROWS, INTS, FLOATS, COEFS, INT0, FLOAT0, COEF0, ENTRIES, SLOT0, SPREADS, ROLE, CONTACT0,
 CONTACTS) = range(13)  # fmt: skip
"""Columns of ``Program.terms``: sizes, where its data begin, rows and columns of its slots in the
matrix, what it is, its first contact and their number."""
SIZES = 13
FORCE, TANGENT, ENERGY, RESPOND, REMEMBER = range(5)
"""Columns of ``Program.kernels``: addresses, 0 where there is none."""
KERNELS = 5
BODY, CONSTRAINT, LOAD, CONTACT = range(4)
"""Roles of terms."""

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

REFRESH = 0.5
"""A contraction of the Newton corrections above this calls for a new Jacobian [-]."""
ACCELERATION, LOOSENESS = 1e-6, 1e6
"""Part of the accelerations that may remain uncorrected: since a correction of q divided by B is
one of a, this keeps forces and multipliers converged when steps are short [-]; it is so many times
the tolerance of the coordinates where that is more."""
ROUND_OFF = 8.0 * 2.220446049250313e-16
"""Corrections below this part of the coordinates mean nothing [-]."""
STALLED = 16.0
"""Corrections that no longer shrink are round-off up to this many of its units [-]."""
FROZEN = 0.35
"""A Jacobian serves step sizes within this fraction of its own [-]."""
LANDING = 1e-6
"""An impact begins, and ends, within this fraction of the clearance before touching [-]."""
CALM = 4
"""Steps between a refusal and the next doubling of the step size."""
IMPACT_RESOLUTION, IMPACT_TOLERANCE, LEAST_RESOLUTION = 32.0, 1e-6, 6.0
"""Steps into which the estimated duration of an impact is divided at a tolerance, as which the
error in restitution falls, since it falls with their square; and at least, below which an impact
would gain energy [-]."""
RELEASED, KEPT_LOSS = 1e3, 0.1
"""Speed that the end of an impact inside a step may add, in that of separation: so many tolerances,
and this part of the factor of hysteresis, which is about 3/2 of what is lost [-]."""
VIOLENT = 0.1
"""Penetration rate, in approach speeds, above which a contact is resolved as an impact [-]."""
DOUBLING_ERROR = 0.1
"""Part of the tolerance below which a local error allows twice the step, eight times the error."""
PRESSED = 0.05
"""Least approach speed, in that of an impact as deep; far below one since the mass that meets is an
estimate, often too small in a mechanism [-]."""
UNMEASURED = -1.0
"""Marks an impact that runs without a positive approach speed: no dissipation is known for it."""
PROJECTIONS = 4
"""Corrections of the positions of a projected step, at most."""
ENOUGH = 2
"""Corrections that a step takes with an exact Jacobian; more are held against it [-]."""
TRUST = 32
"""Steps of one size in which a measured contraction of the corrections is relied upon, at most, and
no more than had been taken with the same factors before [-]."""
SUDDEN = 0.03
"""Least contraction that is relied upon while contacts act [-]."""
CAUTION = 4.0
"""By how much the contraction may have grown since [-]."""


# no wrappers for Python: they take long to compile
_OPTIONS: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
_inner = njit(cache=True, error_model="numpy", **_OPTIONS)


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


class Carried(NamedTuple):
    """What changes from step to step, in place.

    y, v : (n + m,) float  coordinates and multipliers; velocities and zeros
    a : (n,) float;  force : (n,) float  all but inertia
    before : (2, n + m) float  coordinates and velocities one step before (BDF2), or (2, 0)
    approach : (n_c,) float [m/s];  history : (n_c, 7) float  of friction
    ledger : (11,) float [J];  lost : (n_c, 2) float [J]
    clock : (2,) float [s]  time, last step size (0: none yet)
    whole : (6,) int  rung, calm, accepted, refused, corrections, factorisations
    """

    y: Array
    v: Array
    a: Array
    force: Array
    before: Array
    approach: Array
    history: Array
    ledger: Array
    lost: Array
    clock: Array
    whole: Indices


class Window(NamedTuple):
    """span : (3,) float [s]  begin, end of the window, length over which coefficients change
    c0, c1 : (n_c,) float  all coefficients at begin and end; c1 empty: they do not change
    """

    span: Array
    c0: Array
    c1: Array


class Rows(NamedTuple):
    """What is kept of each step.

    t : (k,) float [s];  response : (k, n_c, 32);  approach : (k, n_c) float [m/s]
    drive : (k, n_d) float  multipliers of the driven rows
    lost : (k, n_c, 2) float [J]  normal dissipation and frictional work, since the window began
    y, v : (k, n + m);  ledger : (k, 11) float [J];  or none of these three
    """

    t: Array
    response: Array
    approach: Array
    drive: Array
    lost: Array
    y: Array
    v: Array
    ledger: Array


class Packed(NamedTuple):
    """A program in two arrays.

    Functions with many arrays as arguments take long to compile; so all are parts of few.

    places : (k, 2) int  where each field begins and ends, whole numbers first
    """

    places: Indices
    ints: Indices
    reals: Array


class Memory(NamedTuple):
    """What a march works on: fields ``Y`` to ``STACK`` in ``reals``, and whole numbers."""

    places: Indices
    reals: Array
    whole: Indices


(P_SIZES, P_TERMS, P_KERNELS, P_INTS, P_SLOTS, P_MASS_ROWS, P_MASS_COLUMNS, P_DRIVEN, P_SIGNALS,
 P_SIGNAL, P_CONTACT_AT, P_LATCH_AT, P_LIMITED, P_SOLVER, P_SOLVER_INTS, P_FLOATS, P_MASS,
 P_MASS_DATA, P_SCALE, P_MOBILITY, P_LATCH_VALUE, P_LIMITS) = range(22)  # fmt: skip
"""Fields of a packed program."""
(Y, V, A, FORCE0, BEFORE, APPROACH0, HISTORY0, LEDGER, LOST, CLOCK, SETTINGS, SPAN, C0, C1, ROW_T,
 ROW_RESPONSE, ROW_APPROACH, ROW_DRIVE, ROW_LOST, ROW_Y, ROW_V, ROW_LEDGER, Y1_, V1_, A1_,
 FORCE1, Q_HAT, V_HAT, INERTIA, TOTAL, X, DATA, FACTORS, COEF, ACTING, BEGUN, VALUES, SCRATCH,
 OTHER, THIRD, RATES, TRIED, JACOBIAN, READY, LOOK, STACK, EARLIER, TREND, MOMENTUM) = range(
    49
)  # fmt: skip
"""Fields of the memory: what is carried; the window; rows that are kept; the step that is tried
(names with 1); room to work. ``BEGUN``: coefficients at the beginning of the step. ``TRIED``: time,
B, G, error. ``JACOBIAN``: see there. ``LOOK``: two balances, see ``_look``. ``EARLIER``:
accelerations and multipliers one step before; ``TREND``: how they go on, see ``_begin``.
``MOMENTUM``: M a at the beginning of the step."""

WORST, ROWS_AT, PROJECT_AT, IN_USE = 6, 7, 8, 9
"""Whole numbers of the memory behind those that are carried: the worst unknown; see ``demands``;
the Jacobian in use."""

JACOBIANS = 4
"""Jacobians that are kept, for as many step sizes: impacts make the size go up and down."""
MADE_FOR, WASTED, CONTRACTION, AGE, MEASURED, MEASURED_FOR, USED = range(7)
KNOWN = 7
"""What is known of each: step size it was made for (0: there is none), corrections wasted since,
contraction as last measured, steps taken with it, steps until it was measured (0: not yet), size of
that step, steps and refusals until it was last used."""


_lines = types.Array(types.float64, 1, "C"), types.Array(types.int64, 1, "C")
_places = types.Array(types.int64, 2, "C")
PACKED = types.NamedTuple([_places, _lines[1], _lines[0]], Packed)
MEMORY = types.NamedTuple([_places, _lines[0], _lines[1]], Memory)
DEMAND = types.void(PACKED, MEMORY, types.float64)
ATTEMPT = types.int64(PACKED, MEMORY, types.float64)
LOCATE = types.float64(PACKED, MEMORY, types.float64, types.int64)
TAKE = types.void(PACKED, MEMORY, types.float64, types.int64)
demand_at, attempt_at, locate_at, take_at = at(DEMAND), at(ATTEMPT), at(LOCATE), at(TAKE)


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


def memory(
    program: Program,
    settings: Array,
    window: Window,
    carried: Carried,
    factors: int,
    kept: int,
    full: bool,
) -> Memory:
    """Copies of what is carried and of the window, and room for ``kept`` rows and the work."""
    n, m, joints = map(int, program.sizes[:3])
    y, looks = n + m, 5 + 2 * n + joints * COLUMNS
    driven, some = len(program.driven), kept if full else 0
    given = [*carried[:-1], settings, *window]
    rows = [kept, kept * joints * COLUMNS, kept * joints, kept * driven, 2 * kept * joints,
            some * y, some * y, some * TERMS]  # fmt: skip
    tried = [y, y, n, n, n, n, n, y, y, program.mass_data.size, JACOBIANS * factors]
    tried += [window.c0.size] * 3 + [program.signals.size]
    tried += [y, y, y, 3 * m, 4, JACOBIANS * KNOWN, 2 * joints, 2 * looks, 64 * 9, y, 3, n]
    sizes = [part.size for part in given] + rows + tried
    ends = np.cumsum(sizes)
    reals = np.zeros(ends[-1])
    np.concatenate([part.ravel() for part in given], out=reals[: ends[len(given) - 1]])
    places = np.stack([ends - sizes, ends], axis=1).astype(np.int64)
    return Memory(places, reals, np.append(carried.whole, [0, *demands(int(settings[FORM])), 0]))


def field(store: Memory, name: int, *shape: int) -> Array:
    """A copy of a field of the memory."""
    start, end = store.places[name]
    return store.reals[start:end].reshape(shape or -1).copy()


def _fields(name: str) -> Any:
    """Intrinsic that takes field k of the lines ``name`` of a program or a memory.

    Unchecked and uncounted: it must not outlive the store. A compiled function would take longer to
    compile than all that it does, once for each field.
    """

    @intrinsic
    def function(typing_context, store, k):
        def generate(context, builder, sig, args):
            kinds, names = sig.args[0].types, sig.args[0].fields
            at, line = names.index("places"), names.index(name)
            places = context.make_array(kinds[at])(
                context, builder, builder.extract_value(args[0], at)
            )
            whole = context.make_array(kinds[line])(
                context, builder, builder.extract_value(args[0], line)
            )
            two = builder.mul(
                context.cast(builder, args[1], sig.args[1], types.int64), cgutils.intp_t(2)
            )
            start = builder.load(builder.gep(places.data, [two]))
            end = builder.load(builder.gep(places.data, [builder.add(two, cgutils.intp_t(1))]))
            made = context.make_array(kinds[line])(context, builder)
            count, size = builder.sub(end, start), cgutils.intp_t(8)
            made.data, made.nitems, made.itemsize = builder.gep(whole.data, [start]), count, size
            made.shape = cgutils.pack_array(builder, [count])
            made.strides = cgutils.pack_array(builder, [size])
            made.meminfo = cgutils.get_null_value(made.meminfo.type)
            made.parent = cgutils.get_null_value(made.parent.type)
            return made._getvalue()

        line = store.types[store.fields.index(name)]
        return line(store, types.int64), generate

    return function


_real, _whole = _fields("reals"), _fields("ints")
"""A field of real numbers; a field of whole numbers of a program."""


@_inner
def _copy(source, target):
    """Copy a line; an assignment to a slice takes long to compile."""
    for i in range(source.size):
        target[i] = source[i]


@_inner
def _fill(target, value):
    """Overwrite a line with a number."""
    for i in range(target.size):
        target[i] = value


# ------------------------------------------------------------------------------------ the terms


@_inner
def _ints(p, s):
    start = p.places[P_INTS, 0] + s[INT0]
    return p.ints[start : start + s[ROWS] * s[INTS]].reshape((s[ROWS], s[INTS]))


@_inner
def _floats(p, s):
    start = p.places[P_FLOATS, 0] + s[FLOAT0]
    return p.reals[start : start + s[ROWS] * s[FLOATS]].reshape((s[ROWS], s[FLOATS]))


@_inner
def _coefs(coef, s):
    return coef[s[COEF0] : s[COEF0] + s[ROWS] * s[COEFS]].reshape((s[ROWS], s[COEFS]))


@_inner
def _terms(p):
    """Rows of terms and of their kernels."""
    return _whole(p, P_TERMS).reshape((-1, SIZES)), _whole(p, P_KERNELS).reshape((-1, KERNELS))


@njit(cache=True, error_model="numpy")
def forces(p, y, v, coef, role, out):
    """Add the forces of all terms of a role (-1: all) to ``out`` (n + m,)."""
    terms, kernels = _terms(p)
    for k in range(len(terms)):
        s = terms[k]
        if role < 0 or s[ROLE] == role:
            force_at(kernels[k, FORCE])(y, v, _coefs(coef, s), _ints(p, s), _floats(p, s), out)


@njit(cache=True, error_model="numpy")
def matrix(p, y, v, coef, cM, cK, cC, data):
    """Overwrite ``data`` with [[cM M + cK K + cC C, Phi_q^T], [Phi_q, 0]] on the pattern."""
    mass, slots = _real(p, P_MASS_DATA), _whole(p, P_SLOTS)
    for i in range(data.size):
        data[i] = cM * mass[i]
    terms, kernels = _terms(p)
    for k in range(len(terms)):
        s = terms[k]
        end = s[SLOT0] + s[SPREADS] * s[ENTRIES]
        places = slots[s[SLOT0] : end].reshape((s[SPREADS], s[ENTRIES]))
        tangent_at(kernels[k, TANGENT])(
            y, v, _coefs(coef, s), _ints(p, s), _floats(p, s), cK, cC, places, data
        )


@njit(cache=True, error_model="numpy")
def energies(p, y, v, coef, out):
    """Overwrite ``out`` (4,): energy of bodies, of contacts, power lost, power on free strains."""
    _fill(out, 0.0)
    one = np.zeros(3)
    terms, kernels = _terms(p)
    for k in range(len(terms)):
        s = terms[k]
        if kernels[k, ENERGY] != 0:
            _fill(one, 0.0)
            energy_at(kernels[k, ENERGY])(y, v, _coefs(coef, s), _ints(p, s), _floats(p, s), one)
            out[1 if s[ROLE] == CONTACT else 0] += one[0]
            out[2] += one[1]
            out[3] += one[2]


@njit(cache=True, error_model="numpy")
def respond(p, y, v, coef, response):
    """Overwrite the response (n_c, 32) of all contacts."""
    terms, kernels = _terms(p)
    for k in range(len(terms)):
        s = terms[k]
        if s[ROLE] == CONTACT:
            respond_at(kernels[k, RESPOND])(
                y, v, _coefs(coef, s), _ints(p, s), _floats(p, s),
                response[s[CONTACT0] : s[CONTACT0] + s[CONTACTS]],
            )  # fmt: skip


@_inner
def _remember(p, w):
    """Histories at the end of the step of all contacts whose friction has a memory."""
    terms, kernels = _terms(p)
    history, coef = _real(w, HISTORY0).reshape((-1, HISTORIES)), _real(w, COEF)
    starts = _whole(p, P_CONTACT_AT)
    for k in range(len(terms)):
        s = terms[k]
        if s[ROLE] != CONTACT:
            continue
        remembers = False
        for j in range(s[CONTACT0], s[CONTACT0] + s[CONTACTS]):
            law = coef[starts[j] + LAW_OF_FRICTION]
            remembers = remembers or law in (STICKING, LUGRE, RISING)
        if remembers:
            remember_at(kernels[k, REMEMBER])(
                _real(w, Y1_), _real(w, V1_), _coefs(_real(w, COEF), s), _ints(p, s),
                _floats(p, s), history[s[CONTACT0] : s[CONTACT0] + s[CONTACTS]],
            )  # fmt: skip


@njit(cache=True, error_model="numpy")
def inertia(p, a, out):
    """out (n,) = M a; a number of M stands for the x, y and z of two vectors where it can."""
    rows, columns = _whole(p, P_MASS_ROWS), _whole(p, P_MASS_COLUMNS)
    mass, spatial = _real(p, P_MASS), p.ints[4] == 3
    for i in range(rows.size - 1):
        x, y, z = 0.0, 0.0, 0.0
        for entry in range(rows[i], rows[i + 1]):
            k = np.uint64(entry)
            at, m = np.uint64(columns[k]), mass[k]
            x += m * a[at]
            if spatial:
                y += m * a[at + np.uint64(1)]
                z += m * a[at + np.uint64(2)]
        if spatial:
            out[3 * i], out[3 * i + 1], out[3 * i + 2] = x, y, z
        else:
            out[i] = x
    for i in range(p.ints[4] * (rows.size - 1), out.size):
        out[i] = 0.0


@njit(cache=True, error_model="numpy")
def half_product(v, momentum):
    """Kinetic energy [J] of velocities and momenta (n,)."""
    total = 0.0
    for i in range(momentum.size):
        total += 0.5 * v[i] * momentum[i]
    return total


@njit(cache=True, error_model="numpy")
def write_signals(p, t, values, coef):
    """Set the coefficients that are functions of time to their values at ``t``."""
    at = _whole(p, P_SIGNALS)
    if at.size:
        signals_at(_whole(p, P_SIGNAL)[0])(t, np.int64(values.ctypes.data))
        for i in range(at.size):
            coef[at[i]] = values[i]


@njit(cache=True, error_model="numpy")
def instant(y, v, n):
    """Time step [s] for differences along the motion: a ten thousandth of its own time."""
    far, fast = 0.0, 0.0
    for i in range(n):
        far, fast = max(far, abs(y[i])), max(fast, abs(v[i]))
    return 1e-4 * (1.0 + far) / (1.0 + fast)


@_inner
def _violation(p, w, eps, curved, phi):
    """Overwrite ``phi`` (m,) with Phi at t + eps along the motion of the trial."""
    y, v, a = _real(w, Y1_), _real(w, V1_), _real(w, A1_)
    moved, out, coef = _real(w, OTHER), _real(w, SCRATCH), _acting(p, w)
    n = a.size
    for i in range(n):
        moved[i] = y[i] + eps * v[i] + curved * 0.5 * eps * eps * a[i]
    _fill(moved[n:], 0.0)
    write_signals(p, _real(w, TRIED)[0] + eps, _real(w, VALUES), coef)
    _fill(out, 0.0)
    forces(p, moved, v, coef, CONSTRAINT, out)
    _copy(out[n:], phi)


@_inner
def _factorise(p, w):
    """0 if the matrix could be factorised."""
    ints, data = _whole(p, P_SOLVER_INTS), _real(w, DATA)
    return factor_at(_whole(p, P_SOLVER)[0])(ints, data, _factors(w))


@_inner
def _solve(p, w):
    """The right-hand side becomes the solution."""
    ints, b = _whole(p, P_SOLVER_INTS), _real(w, X)
    solve_at(_whole(p, P_SOLVER)[1])(ints, _factors(w), b)


@_inner
def _factors(w):
    """Factors of the Jacobian in use."""
    whole = _real(w, FACTORS)
    size = whole.size // JACOBIANS
    return whole[size * w.whole[IN_USE] : size * (w.whole[IN_USE] + 1)]


@_inner
def _known(w):
    """What is known of the Jacobian in use."""
    return _real(w, JACOBIAN)[KNOWN * w.whole[IN_USE] : KNOWN * (w.whole[IN_USE] + 1)]


# -------------------------------------------------------------------------------------- one step


@_inner
def _coefficients(p, w, t):
    """Coefficients at time ``t``, linear inside the window."""
    coef, c0, c1, span = _real(w, COEF), _real(w, C0), _real(w, C1), _real(w, SPAN)
    if c1.size:
        s = (t - span[0]) / span[2]
        for i in range(c0.size):
            coef[i] = c0[i] + s * (c1[i] - c0[i])
    write_signals(p, t, _real(w, VALUES), coef)


@_inner
def _acting(p, w):
    """The coefficients with which a step is tried."""
    return _real(w, ACTING) if p.ints[2] else _real(w, COEF)


@_inner
def _write_contacts(p, w, h):
    """What contacts carry with them, and the step for which it holds, among the coefficients."""
    coef, at, approach = _real(w, COEF), _whole(p, P_CONTACT_AT), _real(w, APPROACH0)
    history = _real(w, HISTORY0)
    for j in range(at.size):
        coef[at[j] + ACTIVE], coef[at[j] + APPROACH], coef[at[j] + STEP] = 1.0, approach[j], h
        for i in range(HISTORIES):
            coef[at[j] + HISTORY + i] = history[HISTORIES * j + i]


@_inner
def _let_act(p, w, h):
    """No contact acts in a step that begins in free flight: it ends where the impact begins.

    A force at the end of a long step would slow the journal down before it arrives. A step that is
    short enough to resolve the impact may contain its beginning: the approach speed is that with
    which it begins.
    """
    coef, acting, at = _real(w, COEF), _real(w, ACTING), _whole(p, P_CONTACT_AT)
    approach, ready = _real(w, APPROACH0), _real(w, READY).reshape((at.size, 2))
    if at.size == 0:
        return
    _write_contacts(p, w, h)
    for j in range(at.size):
        if approach[j] == 0.0 and h <= ready[j, 0]:
            coef[at[j] + APPROACH] = ready[j, 1]
    _copy(coef, acting)
    for j in range(at.size):
        if coef[at[j] + APPROACH] == 0.0:
            acting[at[j] + ACTIVE] = 0.0


@_inner
def _get_ready(p, w, response):
    """Step that would resolve the impact which a journal in flight heads for, and its speed."""
    s, approach, coef = _real(w, SETTINGS), _real(w, APPROACH0), _real(w, COEF)
    mobility, at = _real(p, P_MOBILITY), _whole(p, P_CONTACT_AT)
    ready = _real(w, READY).reshape((at.size, 2))
    for j in range(at.size):
        speed = response[j, DEPTH_RATE]
        ready[j, 0], ready[j, 1] = 0.0, speed
        if approach[j] == 0.0 and speed > 0.0:
            mass = meeting_mass(mobility, j, response[j])
            ready[j, 0] = duration(mass, speed, coef[at[j] : at[j] + SLOT]) / _impact_steps(s)


@_inner
def _impact_steps(s):
    """Steps into which the duration of an impact is divided."""
    return max(LEAST_RESOLUTION, IMPACT_RESOLUTION * sqrt(IMPACT_TOLERANCE / s[TOLERANCE]))


@_inner
def _predict(w, h):
    """q^, v^ and the factors B, G of the step."""
    s, step, last = _real(w, SETTINGS), _real(w, TRIED), _real(w, CLOCK)[1]
    y, v, a, q_hat, v_hat = (
        _real(w, Y), _real(w, V), _real(w, A), _real(w, Q_HAT), _real(w, V_HAT)
    )  # fmt: skip
    n = a.size
    if s[KIND] == NEWMARK:
        step[1], step[2] = s[BETA] * h * h, s[GAMMA] * h
        for i in range(n):
            v_hat[i] = v[i] + h * (1.0 - s[GAMMA]) * a[i]
            q_hat[i] = y[i] + h * v[i] + h * h * (0.5 - s[BETA]) * a[i]
        return
    before = _real(w, BEFORE)
    r = h / last if s[KIND] == BDF2 and last > 0.0 else 0.0
    g = h * (1.0 + r) / (1.0 + 2.0 * r)
    one, two = (1.0 + r) ** 2 / (1.0 + 2.0 * r), r * r / (1.0 + 2.0 * r)
    step[1], step[2] = g * g, g
    for i in range(n):
        old_q, old_v = one * y[i], one * v[i]
        if r > 0.0:
            old_q -= two * before[i]
            old_v -= two * before[y.size + i]
        v_hat[i] = old_v
        q_hat[i] = old_q + g * old_v


@_inner
def _place(w):
    """y, v of the trial from its accelerations."""
    y, v, a, step = _real(w, Y1_), _real(w, V1_), _real(w, A1_), _real(w, TRIED)
    q_hat, v_hat = _real(w, Q_HAT), _real(w, V_HAT)
    for i in range(a.size):
        y[i] = q_hat[i] + step[1] * a[i]
        v[i] = v_hat[i] + step[2] * a[i]


@_inner
def _begin(w, h):
    """The trial, with accelerations and multipliers that go on as they did, as far as that helped.

    The part of the last change that is added is what would have been best a step before.
    """
    a1, y1, a, y = _real(w, A1_), _real(w, Y1_), _real(w, A), _real(w, Y)
    earlier, trend, n = _real(w, EARLIER), _real(w, TREND), a1.size
    ahead = trend[0] * h / trend[1] if trend[1] > 0.0 else 0.0
    if ahead == 0.0:
        for i in range(n):
            a1[i] = a[i]
        for i in range(n, y.size):
            y1[i] = y[i]
    else:
        for i in range(n):
            a1[i] = a[i] + ahead * (a[i] - earlier[i])
        for i in range(n, y.size):
            y1[i] = y[i] + ahead * (y[i] - earlier[i])
    _place(w)


@_inner
def _note_trend(p, w, h):
    """How well the change of the accelerations in the last step told that in this one."""
    a0, a1, y0 = _real(w, A), _real(w, A1_), _real(w, Y)
    earlier, trend, n, both, square = _real(w, EARLIER), _real(w, TREND), _real(w, A).size, 0.0, 0.0
    scale = _real(p, P_SCALE)
    if trend[1] > 0.0:
        for i in range(n):
            change = (a0[i] - earlier[i]) / scale[i]
            both += change * (a1[i] - a0[i]) / scale[i]
            square += change * change
        part = both / square * trend[1] / h if square > 0.0 else 0.0
        trend[0] = min(max(part, 0.0), 1.0)
    for i in range(n):
        earlier[i] = a0[i]
    for i in range(n, y0.size):
        earlier[i] = y0[i]
    trend[1] = h


@_inner
def _jacobian(p, w, h):
    """Factorise where the trial is; False if singular."""
    s, step, data, jacobian = _real(w, SETTINGS), _real(w, TRIED), _real(w, DATA), _known(w)
    weight = 1.0 - s[ALPHA_F]
    matrix(
        p, _real(w, Y1_), _real(w, V1_), _acting(p, w), 1.0 - s[ALPHA_M], weight * step[1],
        weight * step[2], data,
    )  # fmt: skip
    total = 0.0
    for i in range(data.size - 1):
        total += data[i]
    _fill(jacobian, 0.0)
    w.whole[5] += 1
    if not np.isfinite(total) or _factorise(p, w) != 0:
        return False
    jacobian[MADE_FOR] = h
    return True


@_inner
def _serves(p, w, h):
    """Whether the Jacobian of an earlier step will do; put the one for this step size into use.

    Not where the corrections that an exact one would have saved have cost as much as it costs.
    Where there is none, the one that has waited longest makes room.
    """
    jacobians, nearest, oldest = _real(w, JACOBIAN), -1, 0
    for k in range(JACOBIANS):
        known = jacobians[KNOWN * k : KNOWN * (k + 1)]
        if known[USED] < jacobians[KNOWN * oldest + USED]:
            oldest = k
        far = abs(h / known[MADE_FOR] - 1.0) if known[MADE_FOR] > 0.0 else np.inf
        if far <= FROZEN and (
            nearest < 0 or far < abs(h / jacobians[KNOWN * nearest + MADE_FOR] - 1.0)
        ):
            nearest = k
    w.whole[IN_USE] = nearest if nearest >= 0 else oldest
    known = _known(w)
    if known[USED] != w.whole[2] + w.whole[3]:  # what was measured before others were in use is old
        known[MEASURED] = 0.0
    return nearest >= 0 and jacobians[KNOWN * nearest + WASTED] <= _whole(p, P_SOLVER)[2]


def decay(p, w, h):
    """Rows of Baumgarte (1972) in place of Phi: Phi'' + 2 w Phi' + w^2 Phi, scaled like Phi.

    Derivatives by central differences along the motion, exact for quadratic constraints.
    """
    s, step, total, n = _real(w, SETTINGS), _real(w, TRIED), _real(w, TOTAL), _real(w, A1_).size
    m = total.size - n
    rates = _real(w, RATES).reshape((3, m))
    eps = instant(_real(w, Y1_), _real(w, V1_), n)
    for k in range(3):
        _violation(p, w, (k - 1) * eps, 1.0, rates[k])
    write_signals(p, step[0], _real(w, VALUES), _acting(p, w))
    rate = s[RATE] if s[RATE] > 0.0 else 2.0 / h
    scale = step[1] / (1.0 + 2.0 * rate * step[2] + rate * rate * step[1])
    for i in range(m):
        bend = (rates[0, i] - 2.0 * rates[1, i] + rates[2, i]) / eps**2
        slope = (rates[2, i] - rates[0, i]) / (2.0 * eps)
        total[n + i] = scale * (bend + 2.0 * rate * slope + rate * rate * rates[1, i])


def velocity_rows(p, w, h):
    """Rows Phi' in place of Phi, scaled like Phi (index 2)."""
    step, total, n = _real(w, TRIED), _real(w, TOTAL), _real(w, A1_).size
    m = total.size - n
    rates = _real(w, RATES).reshape((3, m))
    eps = instant(_real(w, Y1_), _real(w, V1_), n)
    for k in range(2):
        _violation(p, w, (2 * k - 1) * eps, 0.0, rates[k])
    write_signals(p, step[0], _real(w, VALUES), _acting(p, w))
    for i in range(m):
        total[n + i] = step[1] / step[2] * (rates[1, i] - rates[0, i]) / (2.0 * eps)


@_inner
def _mean_inertia(p, w):
    """Overwrite ``INERTIA`` with M ((1 - alpha_m) a1 + alpha_m a0)."""
    s, a1, momentum, inertial = (
        _real(w, SETTINGS), _real(w, A1_), _real(w, MOMENTUM), _real(w, INERTIA)
    )  # fmt: skip
    inertia(p, a1, inertial)
    if s[ALPHA_M] != 0.0:
        for i in range(a1.size):
            inertial[i] = (1.0 - s[ALPHA_M]) * inertial[i] + s[ALPHA_M] * momentum[i]


@_inner
def _residual(p, w, h):
    """Forces and rows of the trial, and right-hand side of its correction."""
    s, step, total, x = _real(w, SETTINGS), _real(w, TRIED), _real(w, TOTAL), _real(w, X)
    a1, force, inertial = _real(w, A1_), _real(w, FORCE0), _real(w, INERTIA)
    n, B, weight = a1.size, step[1], 1.0 - s[ALPHA_F]
    _fill(total, 0.0)
    forces(p, _real(w, Y1_), _real(w, V1_), _acting(p, w), -1, total)
    if w.whole[ROWS_AT] != 0:
        demand_at(w.whole[ROWS_AT])(p, w, h)
    _mean_inertia(p, w)
    for i in range(n):
        x[i] = -B * (inertial[i] + weight * total[i] + s[ALPHA_F] * force[i])
    for i in range(n, total.size):
        x[i] = -total[i]


@_inner
def _trusted(p, w, h):
    """The contraction of corrections with the factors there are; infinite if it is not known.

    It grows with the age of the factors, from nothing when they are new. A contact may begin to
    stick or let go in any step, which no contraction of steps before tells: then only a correction
    that is small itself is relied upon.
    """
    jacobian = _known(w)
    since = jacobian[AGE] - jacobian[MEASURED]
    if (
        not 0 < since <= min(TRUST, jacobian[MEASURED])
        or abs(h / jacobian[MEASURED_FOR] - 1.0) > 1e-6
    ):
        return np.inf
    known, coef = CAUTION * jacobian[CONTRACTION], _acting(p, w)
    for at_ in _whole(p, P_CONTACT_AT):
        if coef[at_ + ACTIVE] != 0.0:
            return max(known, SUDDEN)
    return known


@_inner
def _correct(w):
    """Add the correction to the trial: accelerations, multipliers, coordinates, velocities."""
    s, step, y1, v1, a1 = (
        _real(w, SETTINGS), _real(w, TRIED), _real(w, Y1_), _real(w, V1_), _real(w, A1_)
    )  # fmt: skip
    q_hat, v_hat, x, B, G = _real(w, Q_HAT), _real(w, V_HAT), _real(w, X), step[1], step[2]
    for i in range(a1.size):
        a1[i] += x[i] / B
        y1[i] = q_hat[i] + B * a1[i]
        v1[i] = v_hat[i] + G * a1[i]
    for i in range(a1.size, x.size):
        y1[i] += x[i] / ((1.0 - s[ALPHA_F]) * B)


@_inner
def _in_balance(p, w):
    """Forces of the trial as its accelerations say: the real ones but for what Newton left.

    With them a step shows no defect in the ledger; steps that measure the contraction evaluate
    their forces, and do.
    """
    s, force, force0, inertial = (
        _real(w, SETTINGS), _real(w, FORCE1), _real(w, FORCE0), _real(w, INERTIA)
    )  # fmt: skip
    _mean_inertia(p, w)
    for i in range(force.size):
        force[i] = -(inertial[i] + s[ALPHA_F] * force0[i]) / (1.0 - s[ALPHA_F])


@_inner
def _floor(p, w):
    """Corrections below this mean nothing [-]."""
    y, scale, n, largest = _real(w, Y), _real(p, P_SCALE), _real(w, A1_).size, 0.0
    for i in range(n):
        largest = max(largest, abs(y[i]) / scale[i])
    return ROUND_OFF * largest


@_inner
def _size_of_correction(p, w):
    """Size of a correction, of the accelerations, and the worst unknown; NaN if there is one."""
    a, x, scale = _real(w, A1_), _real(w, X), _real(p, P_SCALE)
    size, moved, worst = 0.0, 0.0, 0
    for i in range(a.size):
        one = abs(x[i]) / scale[i]
        if not one <= size:
            size, worst = one, i
        if np.isnan(one):
            break
        moved = max(moved, abs(a[i]) / scale[i])
    return size, moved, worst


@_inner
def _newton(p, w, h):
    """Correct until the estimated remaining correction is below the tolerance.

    A step takes the contraction of its corrections from earlier ones of the same size with the
    same factors, except every ``TRUST``-th, which measures it.
    Returns the reason (DONE: converged), the number of corrections, the worst unknown.
    """
    s, B, jacobian = _real(w, SETTINGS), _real(w, TRIED)[1], _known(w)
    n, trusted, floor = _real(w, A1_).size, _trusted(p, w, h), _floor(p, w)
    _begin(w, h)
    before, contraction, worst = np.inf, trusted, 0
    part = max(ACCELERATION, LOOSENESS * s[NEWTON])
    for count in range(1, int(s[ITERATIONS]) + 2):
        _residual(p, w, h)
        _solve(p, w)
        size, moved, worst = _size_of_correction(p, w)
        tolerance = max(floor, min(s[NEWTON], part * B * moved))
        if not np.isfinite(size):
            return INFINITE, count, _first_infinite(_real(w, TOTAL), worst)
        if count > 1:
            contraction = size / before
            if contraction > REFRESH and size > max(tolerance, STALLED * floor):
                return UNCONVERGED, count, worst
            if count == 2 or contraction > jacobian[CONTRACTION]:
                jacobian[CONTRACTION] = contraction
            jacobian[MEASURED], jacobian[MEASURED_FOR] = jacobian[AGE], h
        _correct(w)
        done = size == 0.0 or contraction * size <= tolerance
        if done or (count > 1 and contraction > REFRESH):
            jacobian[AGE] += 1.0
            if trusted < np.inf:
                _in_balance(p, w)
            else:
                _residual(p, w, h)
                _copy(_real(w, TOTAL)[:n], _real(w, FORCE1))
            return DONE, count, worst
        before = size
    return UNCONVERGED, int(s[ITERATIONS]) + 1, worst


@_inner
def _first_infinite(total, otherwise):
    for i in range(total.size):
        if not np.isfinite(total[i]):
            return i
    return otherwise


@_inner
def _step(p, w, h):
    """A converged step with a Jacobian that may be old, else with one of the prediction.

    Returns reason, corrections, worst unknown.
    """
    _predict(w, h)
    spent = 0
    for fresh in range(2):
        if fresh:
            _begin(w, h)
            if not _jacobian(p, w, h):
                _residual(p, w, h)
                lost = _first_infinite(_real(w, TOTAL), -1)
                return (SINGULAR, spent, 0) if lost < 0 else (INFINITE, spent, lost)
        elif not _serves(p, w, h):
            continue
        why, count, worst = _newton(p, w, h)
        _known(w)[USED] = w.whole[2] + w.whole[3] + 1.0
        spent += count
        if why == DONE or fresh:
            _known(w)[WASTED] += max(0, count - ENOUGH)
            break
    return why, spent, worst


def project(p, w, h):
    """Positions that obey the constraints, nearest in the metric of the system matrix.

    Where none are found the error of the step becomes infinite.

    The step has made the velocities obey them (index 2); what the positions lack is of third
    order (stabilised index 2; Lunk & Simeon 2006; Jay & Negrut 2007).
    """
    y, x, total, n = _real(w, Y1_), _real(w, X), _real(w, TOTAL), _real(w, A1_).size
    v, coef, scale = _real(w, V1_), _acting(p, w), _real(p, P_SCALE)
    floor, size = 0.0, 0.0
    for i in range(n):
        floor = max(floor, abs(y[i]) / scale[i])
    tolerance = max(_real(w, SETTINGS)[NEWTON], STALLED * ROUND_OFF * floor)
    for _ in range(PROJECTIONS):
        _fill(total, 0.0)
        forces(p, y, v, coef, CONSTRAINT, total)
        _fill(x[:n], 0.0)
        for i in range(n, x.size):
            x[i] = -total[i]
        _solve(p, w)
        size = 0.0
        for i in range(n):
            y[i] += x[i]
            one = abs(x[i]) / scale[i]
            if not one <= size:
                size, w.whole[WORST] = one, i
            if np.isnan(one):
                break
        if not size > tolerance:
            break
    if not size <= tolerance:
        _real(w, TRIED)[3] = np.inf
    _fill(total, 0.0)
    forces(p, y, v, coef, -1, total)
    _copy(total[:n], _real(w, FORCE1))


@cache
def demands(form: int) -> tuple[int, int]:
    """Addresses of what makes the rows other than Phi, and of what ends a step; 0: nothing."""
    if form == BAUMGARTE:
        return kernel(DEMAND)(decay), 0
    if form == PROJECTED:
        return kernel(DEMAND)(velocity_rows), kernel(DEMAND)(project)
    return 0, 0


@_inner
def _error(p, w, h):
    """Local error over the tolerance, and the coordinate where it is.

    Newmark family: (beta - 1/6) h^2 |da| (Zienkiewicz & Xie 1991); BDF2: (2/9) h^2 |da|, backward
    Euler: h^2 |a|/2, their leading terms in q.
    """
    s, a0, a1, scale = _real(w, SETTINGS), _real(w, A), _real(w, A1_), _real(p, P_SCALE)
    factor, kept = abs(s[BETA] - 1.0 / 6.0), 1.0
    if s[KIND] == BDF2:
        factor = 2.0 / 9.0
    elif s[KIND] == EULER:
        factor, kept = 0.5, 0.0
    worst, size = 0, 0.0
    for i in range(a1.size):
        one = abs(a1[i] - kept * a0[i]) / scale[i]
        if not one <= size:
            worst, size = i, one
        if np.isnan(one):
            break
    return factor * h * h * size / s[TOLERANCE], worst


@kernel(ATTEMPT)
def attempt(p, w, h):
    """A converged step within the error tolerance, or the reason."""
    span, step, now = _real(w, SPAN), _real(w, TRIED), _real(w, CLOCK)[0]
    last = now + h > span[1] - 1e-9 * span[2]
    step[0] = span[1] if last else now + h
    _coefficients(p, w, step[0])
    _let_act(p, w, h)
    why, spent, w.whole[WORST] = _step(p, w, h)
    w.whole[4] += spent
    if why != DONE:
        return why
    error, at_ = _error(p, w, h)
    step[3] = error
    if not error <= 1.0:
        w.whole[WORST] = at_
        return INACCURATE
    if w.whole[PROJECT_AT] != 0:
        demand_at(w.whole[PROJECT_AT])(p, w, h)
        if step[3] == np.inf:
            return UNCONVERGED
    limited, limits, y = _whole(p, P_LIMITED), _real(p, P_LIMITS), _real(w, Y1_)
    for i in range(limited.size):
        if not limits[2 * i] <= y[limited[i]] <= limits[2 * i + 1]:
            w.whole[WORST] = i
            return BEYOND
    return DONE


# --------------------------------------------------------------------- impacts: onset and size


@_inner
def _crossing(b, stack):
    """First s in (0, 1) where the polynomial of Bernstein coefficients b (7,) turns positive.

    Bisection by de Casteljau; an interval whose coefficients have one sign holds no root. -1: none.
    """
    depth = 0
    stack[0, :7], stack[0, 7], stack[0, 8] = b, 0.0, 1.0
    now = np.empty(7)
    while depth >= 0:
        low, width = stack[depth, 7], stack[depth, 8]
        now[:] = stack[depth, :7]
        depth -= 1
        if now.min() > 0.0 or now.max() <= 0.0:
            continue
        if width < 1e-15 or depth + 2 >= stack.shape[0]:
            if now[0] <= 0.0 < now[6]:
                return low
            continue
        left, right = stack[depth + 2], stack[depth + 1]
        for k in range(7):
            left[k], right[6 - k] = now[0], now[6 - k]
            for i in range(6 - k):
                now[i] = 0.5 * (now[i] + now[i + 1])
        left[7], left[8] = low, 0.5 * width
        right[7], right[8] = low + 0.5 * width, 0.5 * width
        depth += 2
    return -1.0


@_inner
def _leaving(path, ratio, radius, flat, stack):
    """First s where e leaves the sphere, or passes the plane, at ``radius`` + (``ratio`` - 1) s.

    path : (4, 3)  control points of e, in clearances
    """
    b = np.zeros(7)
    choose, six = (1.0, 3.0, 3.0, 1.0), (1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0)
    for i in range(4):
        ri = radius + (ratio - 1.0) * i / 3.0
        for j in range(4):
            rj = radius + (ratio - 1.0) * j / 3.0
            product = 0.5 * (path[i, 0] + path[j, 0] - ri - rj)
            if not flat:
                product = -ri * rj
                for k in range(3):
                    product += path[i, k] * path[j, k]
            b[i + j] += choose[i] * choose[j] / six[i + j] * product
    return _crossing(b, stack)


@njit(cache=True, error_model="numpy")
def onset(path, c0, c1, flat, stack):
    """Where in (0, 1) a journal is about to touch; -1 if it does not.

    It stops ``LANDING``/2 before. A flight that begins closer than ``LANDING``, as only one from
    the initial state can, may go ``LANDING`` too far.

    Parameters
    ----------
    path : (4, 3) float [m]  control points of e
    c0, c1 : float [m]  clearance at both ends
    flat : whether contact is e[0] > c, otherwise |e| > c
    stack : (64, 9) float  scratch
    """
    path = path / c0
    start = path[0, 0]
    if not flat:
        start = sqrt(path[0, 0] ** 2 + path[0, 1] ** 2 + path[0, 2] ** 2)
    limit = 1.0 if start < 1.0 - LANDING else 1.0 + LANDING
    outside = _leaving(path, c1 / c0, limit, flat, stack)
    if outside < 0.0:
        return -1.0
    before = _leaving(path, c1 / c0, limit - 0.5 * LANDING, flat, stack)
    return min(before, outside) if before > 0.0 else outside


@_inner
def _looked(p, w, which):
    """Parts of a balance: real (5,), external (n,), drive (n,), response (n_c, 32)."""
    n, joints = p.ints[0], p.ints[2]
    size = 5 + 2 * n + joints * COLUMNS
    b = _real(w, LOOK)[which * size : (which + 1) * size]
    contacts = 5 + 2 * n
    return b[:5], b[5 : 5 + n], b[5 + n : contacts], b[contacts:].reshape((joints, COLUMNS))


@_inner
def _release(p, w, h, j, r0, r1):
    """Fraction of the step at which a contact ends; -1 where that may stay inside the step.

    The force at the beginning acts on as if it fell to zero over the whole step, when it has
    already done so on the way. The speed that this adds must be small, and must not make up for
    what the impact loses.
    """
    force = r0[ELASTIC] + r0[DISSIPATIVE]
    if force <= 0.0 or r1[DEPTH] >= 0.0:
        return -1.0
    low, high = 0.0, 1.0
    a, b, c, d = r0[DEPTH], h * r0[DEPTH_RATE] / 3.0, h * r1[DEPTH_RATE] / 3.0, r1[DEPTH]
    for _ in range(40):
        s = 0.5 * (low + high)
        q = 1.0 - s
        deep = q * q * (q * a + 3.0 * s * (a + b)) + s * s * (3.0 * q * (d - c) + s * d) > 0.0
        low, high = (s, high) if deep else (low, s)
    factor = _real(w, COEF)[_whole(p, P_CONTACT_AT)[j] + FACTOR]
    part = max(KEPT_LOSS * factor, LANDING)
    allowed = min(RELEASED * _real(w, SETTINGS)[TOLERANCE], part)
    added = 0.5 * force * h * (1.0 - high) / meeting_mass(_real(p, P_MOBILITY), j, r0)
    return high if added > allowed * abs(r1[DEPTH_RATE]) else -1.0


def locate(p, w, h, old):
    """Fraction of the step at which the first impact begins or ends; -1: none inside.

    The response at the end of the step is kept for the balance there. Journals fly along cubics
    through both ends of the step. One whose control points lie inside the clearance stays there.
    """
    acting, at, first, path = _real(w, ACTING), _whole(p, P_CONTACT_AT), -1.0, np.empty((4, 3))
    joints, stack = at.size, _real(w, STACK)
    response = _looked(p, w, 1 - old)[3]
    respond(p, _real(w, Y1_), _real(w, V1_), _real(w, COEF), response)
    started = _looked(p, w, old)[3]
    for j in range(joints):
        r0, r1 = started[j], response[j]
        if acting[at[j] + ACTIVE] != 0.0:
            part = _release(p, w, h, j, r0, r1)
            if part > 0.0 and (first < 0.0 or part < first):
                first = part
            continue
        flat = r0[FLAT] != 0.0
        for k in range(3):
            path[0, k], path[1, k] = r0[PATH + k], r0[PATH + k] + h / 3.0 * r0[PATH_RATE + k]
            path[2, k], path[3, k] = r1[PATH + k] - h / 3.0 * r1[PATH_RATE + k], r1[PATH + k]
        reach = path[0, 0]
        for i in range(4):
            one = path[i, 0]
            if not flat:
                one = sqrt(path[i, 0] ** 2 + path[i, 1] ** 2 + path[i, 2] ** 2)
            reach = max(reach, one)
        near = (1.0 - LANDING) * min(r0[GAP], r1[GAP])
        if near <= 0.0 or reach > near:
            at_ = onset(path, r0[GAP], r1[GAP], flat, stack.reshape((64, 9)))
            if at_ > 0.0 and (first < 0.0 or at_ < first):
                first = at_
    return first


@cache
def locating() -> int:
    """Address of ``locate``."""
    return kernel(LOCATE)(locate)


@_inner
def _catching(p, w):
    """Fraction of the step at which the first latch reaches its place; -1: none does."""
    values, at, coef = _real(p, P_LATCH_VALUE), _whole(p, P_LATCH_AT), _real(w, COEF)
    y0, y1, first = _real(w, Y), _real(w, Y1_), -1.0
    for i in range(values.size):
        k = at[2 * i]
        before, now = y0[k] - values[i], y1[k] - values[i]
        sign = 1.0 if values[i] >= 0.0 else -1.0
        if coef[at[2 * i + 1]] == 0.0 and sign * before < 0.0 <= sign * now:
            part = before / (before - now)
            if first < 0.0 or part < first:
                first = part
    return first


@njit(cache=True, error_model="numpy")
def meeting_mass(mobility, j, r):
    """Mass [kg] that meets in contact j along the direction of its gap."""
    W = mobility.reshape((-1, 3, 3))[j]
    square, give = r[PATH] ** 2 + r[PATH + 1] ** 2 + r[PATH + 2] ** 2, 0.0
    if r[FLAT] != 0.0 or square == 0.0:
        return 1.0 / W[0, 0]
    for i in range(3):
        for k in range(3):
            give += r[PATH + i] * W[i, k] * r[PATH + k]
    return square / give


@njit(cache=True, error_model="numpy")
def note_approach(contact_at, coef, mobility, response, approach):
    """Approach speed of each running impact: the largest since its onset; 0 once it is over.

    Taking the largest keeps the rate ratio of the hysteresis laws below one in contacts that
    are loaded anew without a separation. It is never less than ``PRESSED`` of the speed at which
    an impact would go as deep: pressing slowly is no impact, and what rates a contact at rest has
    are rounding errors. Once begun, an impact is over when the journal is clearly apart, so that
    no flight is too short for its end to be located.
    """
    for j in range(approach.size):
        gap, rate, near = response[j, DEPTH], response[j, DEPTH_RATE], abs(response[j, GAP])
        closing = rate > 0.0 or approach[j] != 0.0
        if gap > 0.0 or (gap > -LANDING * near and closing):
            row = coef[contact_at[j] : contact_at[j] + SLOT]
            largest = max(approach[j], rate, row[APPROACH])
            mass = meeting_mass(mobility, j, response[j])
            largest = max(largest, PRESSED * sqrt(2.0 * stored(gap, row) / mass))
            approach[j] = largest if largest > 0.0 else UNMEASURED
        else:
            approach[j] = 0.0


@_inner
def _rung_below(s, h):
    """First rung of the ladder whose step is not longer than ``h``."""
    return max(0, ceil(log2(s[LARGEST] / max(h, s[SMALLEST])) - 1e-9))


@_inner
def _impact_rung(p, w, response):
    """Rung that resolves the impacts in which penetration changes noticeably; 0 if none does.

    Noticeably is against the approach speed and against the speed of an impact as deep.
    """
    s, approach, coef = _real(w, SETTINGS), _real(w, APPROACH0), _real(w, COEF)
    mobility, contact_at, rung = _real(p, P_MOBILITY), _whole(p, P_CONTACT_AT), 0
    for j in range(approach.size):
        speed, row = approach[j], coef[contact_at[j] : contact_at[j] + SLOT]
        if speed == 0.0:
            continue
        mass = meeting_mass(mobility, j, response[j])
        pressed = sqrt(2.0 * stored(response[j, DEPTH], row) / mass)
        if abs(response[j, DEPTH_RATE]) > VIOLENT * max(speed, pressed):
            last = duration(mass, max(speed, 1e-9), row)
            rung = max(rung, _rung_below(s, last / _impact_steps(s)))
    return rung


@_inner
def _next_rung(p, w, response, error):
    """Steps that resolve running impacts; longer ones when the error has been small for long."""
    w.whole[1] += 1
    finest = _impact_rung(p, w, response)
    if finest > 0 and finest >= w.whole[0]:  # calm begins anew: turning points of impacts are short
        w.whole[0], w.whole[1] = finest, 0
    elif w.whole[0] > finest and w.whole[1] >= CALM and error < DOUBLING_ERROR:
        w.whole[0], w.whole[1] = w.whole[0] - 1, 0


# ------------------------------------------------------------------------------------- energies


@_inner
def _look(p, w, y, v, coef, which):
    """Fill a balance: kinetic, strain, contact energy, powers lost and on free strains; forces of
    loads and of driven constraints. The response of contacts is there already, see ``locate``.
    """
    n, out, inertial = p.ints[0], _real(w, SCRATCH), _real(w, THIRD)[: p.ints[0]]
    real, external, drive, _ = _looked(p, w, which)
    inertia(p, v, inertial)
    real[0] = half_product(v, inertial)
    energies(p, y, v, coef, real[1:])
    _fill(out, 0.0)
    forces(p, y, v, coef, LOAD, out)
    for i in range(n):
        external[i] = -out[i]
    driven, masked = _whole(p, P_DRIVEN), _real(w, OTHER)
    if driven.size:
        _copy(y[:n], masked)
        _fill(masked[n:], 0.0)
        _fill(out, 0.0)
        for row in driven:
            masked[n + row] = y[n + row]
        forces(p, masked, v, coef, CONSTRAINT, out)
        _copy(out[:n], drive)


@_inner
def _rubbed(r0, r1, h):
    """Work of friction [J]: mean force and moment times the way and the turn of the journal.

    The turn of a step is known to ± pi. Where the pose is not known, mean force times mean slip.
    """
    work, known = 0.0, r1[AXIS] != 0.0 or r1[AXIS + 1] != 0.0 or r1[AXIS + 2] != 0.0
    if not known:
        for i in range(3):
            mean = r0[FRICTION + i] + r1[FRICTION + i]
            work -= 0.25 * h * mean * (r0[SLIP + i] + r1[SLIP + i])
        return work
    sine, square, trace = np.zeros(3), 0.0, 0.0
    for first in (AXIS, SIDE, -1):
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            a, b = _direction(r0, first, j), _direction(r0, first, k)
            c, d = _direction(r1, first, j), _direction(r1, first, k)
            sine[i] += 0.5 * (a * d - b * c)
            trace += a * c
    for i in range(3):
        square += sine[i] ** 2
    turn = np.arctan2(sqrt(square), 0.5 * (trace - 1.0)) / sqrt(square) if square > 0.0 else 1.0
    for i in range(3):
        work -= 0.5 * (r0[FRICTION + i] + r1[FRICTION + i]) * (r1[CENTRE + i] - r0[CENTRE + i])
        work -= 0.5 * (r0[MOMENT + i] + r1[MOMENT + i]) * turn * sine[i]
    return work


@_inner
def _direction(r, first, i):
    """Component i of a direction of the journal; -1: the one across the other two."""
    if first >= 0:
        return r[first + i]
    j, k = (i + 1) % 3, (i + 2) % 3
    return r[AXIS + j] * r[SIDE + k] - r[AXIS + k] * r[SIDE + j]


@_inner
def _contact_losses(p, w, h, old, new):
    """Add what each contact lost over the step to ``LOST``; sums of hysteresis and friction.

    Mean forces times ways: of the normal force along the gap, of friction see ``_rubbed``.
    """
    lost, hysteresis, friction = _real(w, LOST), 0.0, 0.0
    response0, response1 = _looked(p, w, old)[3], _looked(p, w, new)[3]
    for j in range(len(response0)):
        r0, r1 = response0[j], response1[j]
        if r0[ELASTIC] == 0.0 and r1[ELASTIC] == 0.0:
            continue
        way = r1[DEPTH] + r1[GAP] - r0[DEPTH] - r0[GAP]
        pressed, rubbed = 0.5 * (r0[DISSIPATIVE] + r1[DISSIPATIVE]) * way, _rubbed(r0, r1, h)
        lost[2 * j] += pressed
        lost[2 * j + 1] += rubbed
        hysteresis += pressed
        friction += rubbed
    return hysteresis, friction


@_inner
def _changing(p, w):
    """Whether energies depend on time by their coefficients."""
    return _real(w, C1).size > 0 or p.ints[3] != 0


@_inner
def _heating(p, w, before, after):
    """Energy [J] that a change of coefficients brings, mean over both ends of a step.

    They change with temperature, or by functions of time such as the rope that a winch pays out.
    """
    if not _changing(p, w):
        return 0.0
    out = np.zeros(4)
    energies(p, _real(w, Y), _real(w, V), _real(w, COEF), out)
    first = out[0] + out[1] - before[1] - before[2]
    energies(p, _real(w, Y1_), _real(w, V1_), _real(w, BEGUN), out)
    return 0.5 * (first + after[1] + after[2] - out[0] - out[1])


@_inner
def _scheme_work(p, w, h):
    """Energy that a scheme itself adds over a step beyond -dq.(F0 + F1)/2 [J].

    Newmark's update makes the change of kinetic energy exactly

        dK = dq.M(a0 + a1)/2 + (g - 1/2) dq.M da - h^2 (b - g/2) da.M((a0 + a1)/2 + (g - 1/2) da)

    and M a1 follows from the forces by the balance of the step (Krenk & Hogsberg 2005 give the
    linear case of HHT). BDF and projected positions have no such relation: there the kinetic
    energies themselves are taken, (v0 + v1).M(v1 - v0)/2.
    """
    s, y0, y1, v0, v1 = _real(w, SETTINGS), _real(w, Y), _real(w, Y1_), _real(w, V), _real(w, V1_)
    a0, a1, F0, F1 = _real(w, A), _real(w, A1_), _real(w, FORCE0), _real(w, FORCE1)
    M0, mean, total, n = _real(w, MOMENTUM), _real(w, INERTIA), 0.0, a0.size
    if s[KIND] != NEWMARK or s[FORM] == PROJECTED:
        other, Ma = _real(w, OTHER), _real(w, THIRD)
        for i in range(n):
            other[i] = v1[i] - v0[i]
        inertia(p, other, Ma[:n])
        for i in range(n):
            total += 0.5 * ((v1[i] + v0[i]) * Ma[i] + (y1[i] - y0[i]) * (F0[i] + F1[i]))
        return total
    excess, drift = s[GAMMA] - 0.5, h * h * (s[BETA] - 0.5 * s[GAMMA])
    for i in range(n):
        by_force = (1.0 - s[ALPHA_F]) * F1[i] + s[ALPHA_F] * F0[i]
        made = -(by_force + s[ALPHA_M] * M0[i]) / (1.0 - s[ALPHA_M])  # M a1 by the forces
        more = (mean[i] - M0[i]) / (1.0 - s[ALPHA_M])  # M (a1 - a0)
        dq = y1[i] - y0[i]
        half = 0.5 * (a0[i] + a1[i]) + excess * (a1[i] - a0[i])
        total += 0.5 * dq * (M0[i] + made + F0[i] + F1[i]) + more * (excess * dq - drift * half)
    return total


@_inner
def _book(p, w, h, old, new):
    """Add the step to the ledger; see ``mechanics.ledger``."""
    y0, y1, F0, F1 = _real(w, Y), _real(w, Y1_), _real(w, FORCE0), _real(w, FORCE1)
    before, external0, drive0 = _looked(p, w, old)[:3]
    after, external1, drive1 = _looked(p, w, new)[:3]
    hysteresis, friction = _contact_losses(p, w, h, old, new)
    loads, drive, by_forces = 0.0, 0.0, 0.0
    for i in range(F0.size):
        dq = 0.5 * (y1[i] - y0[i])
        loads += dq * (external0[i] + external1[i])
        drive -= dq * (drive0[i] + drive1[i])
        by_forces -= dq * (F0[i] + F1[i])
    damping = 0.5 * h * (before[3] + after[3])
    heating = _heating(p, w, before, after) - 0.5 * h * (before[4] + after[4])
    known = loads + drive + heating - hysteresis - friction - damping
    stored = after[1] + after[2] - before[1] - before[2]
    numerical = known - stored - by_forces - _scheme_work(p, w, h)
    defect = after[0] - before[0] + stored - (known - numerical)
    ledger = _real(w, LEDGER)
    _copy(after[:3], ledger)
    ledger[WORK_LOADS] += loads
    ledger[WORK_DRIVE] += drive
    ledger[WORK_THERMAL] += heating
    ledger[RUBBED] += friction
    ledger[HYSTERESIS] += hysteresis
    ledger[DAMPING] += damping
    ledger[NUMERICAL] += numerical
    ledger[DEFECT] += defect


# ---------------------------------------------------------------------------------- the march


@kernel(TAKE)
def take(p, w, h, old):
    """Book the step, update the running impacts and choose the next rung."""
    y, v, clock, before = _real(w, Y), _real(w, V), _real(w, CLOCK), _real(w, BEFORE)
    coef, new = _real(w, COEF), 1 - old
    _look(p, w, _real(w, Y1_), _real(w, V1_), coef, new)
    _book(p, w, h, old, new)
    if before.size:
        _copy(y, before)
        _copy(v, before[y.size :])
    _note_trend(p, w, h)
    _copy(_real(w, Y1_), y)
    _copy(_real(w, V1_), v)
    _copy(_real(w, A1_), _real(w, A))
    _copy(_real(w, FORCE1), _real(w, FORCE0))
    if _real(w, SETTINGS)[ALPHA_M] == 0.0:
        _copy(_real(w, INERTIA), _real(w, MOMENTUM))
    else:
        inertia(p, _real(w, A), _real(w, MOMENTUM))
    clock[0], clock[1] = _real(w, TRIED)[0], h
    response = _looked(p, w, new)[3]
    if p.ints[2]:
        _remember(p, w)
        mobility = _real(p, P_MOBILITY)
        note_approach(_whole(p, P_CONTACT_AT), coef, mobility, response, _real(w, APPROACH0))
        _get_ready(p, w, response)
    w.whole[2] += 1
    _next_rung(p, w, response, _real(w, TRIED)[3])


@_inner
def _size(w, target):
    """Step size on the ladder that ends the window in a whole number of steps, or the target."""
    if target > 0.0:
        return target
    remaining = _real(w, SPAN)[1] - _real(w, CLOCK)[0]
    rung = _real(w, SETTINGS)[LARGEST] / 2.0 ** w.whole[0]
    return remaining / max(1, ceil(remaining / rung - 1e-6))


@_inner
def _substep(p, w, old):
    """One accepted step, whatever number of refused ones it takes: reason, worst unknown."""
    target, s, addresses = -1.0, _real(w, SETTINGS), _whole(p, P_SOLVER)
    while True:
        h = _size(w, target)
        why = attempt_at(addresses[3])(p, w, h)
        worst = w.whole[WORST]
        if why == DONE:
            landing = locate_at(addresses[4])(p, w, h, old) if addresses[4] != 0 else -1.0
            caught = _catching(p, w)
            if 0.0 < caught < 1.0 - 1e-6 and (landing < 0.0 or caught < landing):
                landing = min(1.0, caught * (1.0 + 1e-9))
            if landing < 0.0:
                take_at(addresses[5])(p, w, h, old)
                return LATCHED if caught > 0.0 else DONE, worst
            target = landing * h
            continue
        w.whole[3] += 1
        if h <= 2.0 * s[SMALLEST]:
            return why, worst
        if target > 0.0:
            target *= 0.5
        else:
            w.whole[0], w.whole[1] = _rung_below(s, 0.5 * h * (1.0 + 1e-9)), 0


@_inner
def _enter(p, w):
    """Begin a window; a jump of coefficients or masses since the last one is work of heating."""
    coef, ledger = _real(w, COEF), _real(w, LEDGER)
    _copy(_real(w, C0), coef)
    _coefficients(p, w, _real(w, CLOCK)[0])
    _write_contacts(p, w, 0.0)
    _look(p, w, _real(w, Y), _real(w, V), coef, 0)
    respond(p, _real(w, Y), _real(w, V), coef, _looked(p, w, 0)[3])
    inertia(p, _real(w, A), _real(w, MOMENTUM))
    now = _looked(p, w, 0)[0]
    _get_ready(p, w, _looked(p, w, 0)[3])
    for k in range(3):
        ledger[WORK_THERMAL] += now[k] - ledger[k]
    _copy(now[:3], ledger)


@_inner
def _keep(p, w, count, new):
    """Keep a row of what the observer wants."""
    y, response, driven = _real(w, Y), _looked(p, w, new)[3], _whole(p, P_DRIVEN)
    joints, size = response.shape[0], y.size
    _real(w, ROW_T)[count] = _real(w, CLOCK)[0]
    at = count * joints
    for j in range(joints):
        _copy(response[j], _real(w, ROW_RESPONSE)[(at + j) * COLUMNS :])
    _copy(_real(w, APPROACH0), _real(w, ROW_APPROACH)[at:])
    _copy(_real(w, LOST), _real(w, ROW_LOST)[2 * at :])
    for i in range(driven.size):
        _real(w, ROW_DRIVE)[count * driven.size + i] = y[p.ints[0] + driven[i]]
    if _real(w, ROW_Y).size:
        _copy(y, _real(w, ROW_Y)[count * size :])
        _copy(_real(w, V), _real(w, ROW_V)[count * size :])
        _copy(_real(w, LEDGER), _real(w, ROW_LEDGER)[count * TERMS :])


@njit(cache=True, error_model="numpy")
def march(p, w):
    """Carry the state in the memory to the end of the window, or as far as it goes.

    Parameters
    ----------
    p : Packed  the program
    w : Memory

    Returns
    -------
    how it ended, number of rows, the worst unknown of a step that was not possible
    """
    _enter(p, w)
    count, old, kept = 0, 0, _real(w, ROW_T).size
    clock, end = _real(w, CLOCK), _real(w, SPAN)[1]
    while clock[0] < end:
        if count == kept:
            return FULL, count, 0
        if _changing(p, w):
            _copy(_real(w, COEF), _real(w, BEGUN))
        why, worst = _substep(p, w, old)
        if why != DONE and why != LATCHED:
            return why, count, worst
        old = 1 - old
        _keep(p, w, count, old)
        count += 1
        if why == LATCHED:
            return LATCHED, count, worst
    return DONE, count, 0
