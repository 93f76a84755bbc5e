"""What a march works on: fields of one store, how they are taken, and what is called by address."""

from typing import Any, NamedTuple

from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from mechanics.kernels import at
from mechanics.march.program import COLUMNS, Array, Indices, Packed

# no wrappers for Python: they take long to compile
_OPTIONS: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
inner = njit(cache=True, error_model="numpy", **_OPTIONS)


class Carried(NamedTuple):
    """What changes from step to step, in place.

    y, v : (n + m,) float  coordinates and multipliers; velocities and zeros
    a : (n,) float;  force : (n,) float  all but inertia
    before : (2, n + m) float  coordinates and velocities one step before (BDF2), or (2, 0)
    approach : (n_c,) float [m/s];  history : (n_c, 7) float  of friction
    ledger : (11,) float [J];  lost : (n_c, 2) float [J]
    clock : (4,) float  time [s], last step size [s] (0: none yet), sum and largest of the local
        errors of the steps relative to the sizes of the coordinates
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


class Memory(NamedTuple):
    """What a march works on: fields ``Y`` to ``STACK`` in ``reals``, and whole numbers."""

    places: Indices
    reals: Array
    whole: Indices


(Y, V, A, FORCE0, BEFORE, APPROACH0, HISTORY0, LEDGER, LOST, CLOCK, SETTINGS, SPAN, C0, C1, ROW_T,
 ROW_RESPONSE, ROW_APPROACH, ROW_DRIVE, ROW_LOST, ROW_Y, ROW_V, ROW_LEDGER, Y1_, V1_, A1_,
 FORCE1, Q_HAT, V_HAT, INERTIA, TOTAL, X, DATA, FACTORS, COEF, ACTING, BEGUN, VALUES, SCRATCH,
 OTHER, THIRD, RATES, TRIED, JACOBIAN, READY, LOOK, STACK, EARLIER, TREND, MOMENTUM,
 BODIES) = range(50)  # fmt: skip
"""Fields of the memory: what is carried; the window; rows that are kept; the step that is tried
(names with 1); room to work. ``BEGUN``: coefficients at the beginning of the step. ``TRIED``: time,
B, G, error over the tolerance, error. ``JACOBIAN``: see there. ``LOOK``: two balances, see
``look``. ``EARLIER``: accelerations and multipliers one step before; ``TREND``: how they go on, see
``begin``. ``MOMENTUM``: M a at the beginning of the step. ``BODIES``: K and C of bodies and the
coordinates where they were taken, or no room for them."""

WORST, ROWS_AT, PROJECT_AT, IN_USE, TAKEN, FAILED = 6, 7, 8, 9, 10, 11
"""Whole numbers of the memory behind those that are carried: the worst unknown; see ``demands``;
the Jacobian in use; the attempt in which K and C of bodies were taken (0: they were not), and the
step in which one failed last, both counted from 1."""

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


def field(store: Memory, name: int, *shape: int, count: int | None = None) -> Array:
    """A copy of a field of the memory, or of the first ``count`` rows of it."""
    start, end = store.places[name]
    return store.reals[start:end].reshape(shape or -1)[:count].copy()


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


reals, wholes = _fields("reals"), _fields("ints")
"""A field of real numbers; a field of whole numbers of a program."""


@inner
def copy(source, target):
    """Copy a line; an assignment to a slice takes long to compile."""
    for i in range(source.size):
        target[i] = source[i]


@inner
def fill(target, value):
    """Overwrite a line with a number."""
    for i in range(target.size):
        target[i] = value


@inner
def acting(p, w):
    """The coefficients with which a step is tried."""
    return reals(w, ACTING) if p.ints[2] else reals(w, COEF)


@inner
def looked(p, w, which):
    """Parts of a balance: real (5,), external (n,), drive (n,), response (n_c, 32)."""
    n, joints = p.ints[0], p.ints[2]
    size = 5 + 2 * n + joints * COLUMNS
    b = reals(w, LOOK)[which * size : (which + 1) * size]
    contacts = 5 + 2 * n
    return b[:5], b[5 : 5 + n], b[5 + n : contacts], b[contacts:].reshape((joints, COLUMNS))
