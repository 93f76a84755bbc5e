"""What compiled kernels look like from outside, and how compiled code calls them.

A term keeps its data in flat arrays with one row for each element: ``ints``, ``floats`` (what
never changes) and ``coef`` (what follows temperature and time). Its kernels are compiled on their
own, in the file of their family, and are known to the integrator by address: it is compiled once,
whatever a scene consists of, and a scene compiles no kernel that it does not use.

All kernels see the unknowns y = (q, lambda), n coordinates and m multipliers, and velocities
v = (dq/dt, 0) of the same length.
"""

import ctypes
import signal
import threading
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import cfunc, float64, int64, njit, void
from numba.core import cgutils, types
from numba.extending import intrinsic
from numpy.typing import NDArray

from mechanics.caching import watch

watch()

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_line, _table = float64[::1], float64[:, ::1]
_whole, _wholes = int64[::1], int64[:, ::1]

FORCE = void(_line, _line, _table, _wholes, _table, _line)
"""force(y, v, coef, ints, floats, out): add f to out[:n] and, for constraints, Phi to out[n:]."""
TANGENT = void(_line, _line, _table, _wholes, _table, float64, float64, _wholes, _line)
"""tangent(y, v, coef, ints, floats, cK, cC, slots, data): add cK df/dq + cC df/dv, and for
constraints Phi_q and its transpose, not multiplied by anything, to data[slots[e, i k + j]]."""
ENERGY = void(_line, _line, _table, _wholes, _table, _line)
"""energy(y, v, coef, ints, floats, out): add stored energy [J], power [W] lost in damping, power
[W] done by damping on changing free strains to out (3,)."""
RESPOND = void(_line, _line, _table, _wholes, _table, _table)
"""respond(y, v, coef, ints, floats, response): columns (``mechanics.march``) of each contact."""
REMEMBER = void(_line, _line, _table, _wholes, _table, _table)
"""remember(y, v, coef, ints, floats, history): history (n_c, 7) of each contact at the end of the
step for which the coefficients hold the history at its beginning."""
FACTOR = int64(_whole, _line, _line)
"""factor(ints, data, work): 0, or 1 where the matrix is singular."""
SOLVE = void(_whole, _line, _line)
"""solve(ints, work, b): b becomes the solution."""
SIGNALS = void(float64, int64)
"""signals(t, address): write the functions of time to the doubles at ``address``."""
OUTSIDE = int64(int64)
"""outside(address): a factorisation or solution by a library, on the doubles at ``address``."""


def kernel(signature: Any) -> Callable[[Callable], int]:
    """Compile (cached) for ``signature``; what remains is the address of the function."""

    def compiled(function: Callable) -> int:
        made: Any = cfunc(signature, cache=True, error_model="numpy")(function)
        _KEPT.append(made)
        return int(made.address)

    return compiled


_KEPT: list[Any] = []
"""Compiled functions, and Python functions that compiled code calls; never freed."""


def callback(
    function: Callable[..., Any], *kinds: Any, returns: Any = None, keep: list[Any] = _KEPT
) -> int:
    """Address under which compiled code can call a Python function of ctypes ``kinds``.

    It holds as long as the list ``keep`` does.
    """
    made = ctypes.CFUNCTYPE(returns, *kinds)(function)
    keep.append(made)
    return int(ctypes.cast(made, ctypes.c_void_p).value or 0)


INTERRUPTS: list[int] = []
"""Signals of interrupts that arrived while compiled code was at work."""


def uninterrupted(work: Callable[..., Any], *arguments: Any) -> Any:
    """Result of compiled code that calls Python functions; an interrupt waits until it returns.

    Python would raise it at the beginning of such a function, from which nothing can be raised
    through compiled code: the interrupt would be lost, and what the function should have written.
    """
    before = signal.getsignal(signal.SIGINT)
    if not callable(before) or threading.current_thread() is not threading.main_thread():
        return work(*arguments)
    signal.signal(signal.SIGINT, lambda number, _: INTERRUPTS.append(number))
    try:
        return work(*arguments)
    finally:
        signal.signal(signal.SIGINT, before)
        if INTERRUPTS:
            INTERRUPTS.clear()
            signal.raise_signal(signal.SIGINT)


def at(signature: Any) -> Any:
    """Intrinsic that makes a callable of ``signature`` from an address."""
    kind = types.FunctionType(signature)

    @intrinsic
    def function(typing_context, address):
        def generate(context, builder, sig, args):
            made = cgutils.create_struct_proxy(kind)(context, builder)
            made.c_addr = builder.inttoptr(args[0], cgutils.voidptr_t)
            return made._getvalue()

        return kind(types.int64), generate

    return function


force_at = at(FORCE)
tangent_at = at(TANGENT)
energy_at = at(ENERGY)
respond_at = at(RESPOND)
remember_at = at(REMEMBER)
factor_at = at(FACTOR)
solve_at = at(SOLVE)
signals_at = at(SIGNALS)
outside_at = at(OUTSIDE)


@njit(cache=True)
def _force(address, y, v, coef, ints, floats, out):
    force_at(address)(y, v, coef, ints, floats, out)


@njit(cache=True)
def _tangent(address, y, v, coef, ints, floats, cK, cC, slots, data):
    tangent_at(address)(y, v, coef, ints, floats, cK, cC, slots, data)


@njit(cache=True)
def _energy(address, y, v, coef, ints, floats, out):
    energy_at(address)(y, v, coef, ints, floats, out)


@njit(cache=True)
def _respond(address, y, v, coef, ints, floats, response):
    respond_at(address)(y, v, coef, ints, floats, response)


@njit(cache=True)
def _remember(address, y, v, coef, ints, floats, history):
    remember_at(address)(y, v, coef, ints, floats, history)


def add_force(term: Any, y: Array, v: Array, coef: Array, out: Array) -> None:
    """Add the resisting force (and constraint values) of a term to ``out`` (n + m,)."""
    _force(term.force, y, v, coef, term.ints, term.floats, out)


def add_tangent(
    term: Any, y: Array, v: Array, coef: Array, cK: float, cC: float, slots: Indices, data: Array
) -> None:
    """Add the tangent of a term to ``data`` at ``slots`` (n_e, k k)."""
    _tangent(term.tangent, y, v, coef, term.ints, term.floats, cK, cC, slots, data)


def energies(term: Any, y: Array, v: Array, coef: Array) -> Array:
    """(3,) stored energy [J], powers [W] lost in damping and done on changing free strains."""
    out = np.zeros(3)
    if term.energy:
        _energy(term.energy, y, v, coef, term.ints, term.floats, out)
    return out


def responses(term: Any, y: Array, v: Array, coef: Array, columns: int) -> Array:
    """Response (n_c, columns) of a term of contacts."""
    response = np.zeros((len(coef) * term.slots, columns))
    _respond(term.respond, y, v, coef, term.ints, term.floats, response)
    return response


def histories(term: Any, y: Array, v: Array, coef: Array, columns: int) -> Array:
    """History (n_c, columns) of a term of contacts at the end of a step."""
    history = np.zeros((len(coef) * term.slots, columns))
    _remember(term.remember, y, v, coef, term.ints, term.floats, history)
    return history


def tangent_blocks(
    term: Any, y: Array, v: Array, coef: Array, cK: float, cC: float
) -> NDArray[np.float64]:
    """(n_e, k, k) tangents of all elements, for tests and dense work."""
    count, k = getattr(term, "pattern_dofs", term.dofs).shape
    data = np.zeros(count * k * k)
    slots = np.arange(count * k * k, dtype=np.int64).reshape(count, k * k)
    add_tangent(term, y, v, coef, cK, cC, slots, data)
    return data.reshape(count, k, k)
