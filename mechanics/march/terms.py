"""The sums over the terms of a scene: forces, matrix, energies, contacts; inertia and signals."""

import numpy as np
from numba import njit

from mechanics.contact_laws import FRICTION as LAW_OF_FRICTION
from mechanics.contact_laws import HISTORIES, LUGRE, RISING
from mechanics.contact_laws import STICK as STICKING
from mechanics.kernels import (
    energy_at,
    force_at,
    remember_at,
    respond_at,
    signals_at,
    tangent_at,
)
from mechanics.march.program import (
    COEF0,
    COEFS,
    CONTACT,
    CONTACT0,
    CONTACTS,
    ENERGY,
    ENTRIES,
    FLOAT0,
    FLOATS,
    FORCE,
    INT0,
    INTS,
    KERNELS,
    P_CONTACT_AT,
    P_FLOATS,
    P_INTS,
    P_KERNELS,
    P_MASS,
    P_MASS_COLUMNS,
    P_MASS_DATA,
    P_MASS_ROWS,
    P_SIGNAL,
    P_SIGNALS,
    P_SLOTS,
    P_TERMS,
    REMEMBER,
    RESPOND,
    ROLE,
    ROWS,
    SIZES,
    SLOT0,
    SPREADS,
    TANGENT,
)
from mechanics.march.store import (
    C0,
    C1,
    COEF,
    HISTORY0,
    SPAN,
    V1_,
    VALUES,
    Y1_,
    fill,
    inner,
    reals,
    wholes,
)


@inner
def _ints(p, s):
    start = p.places[P_INTS, 0] + s[INT0]
    return p.ints[start : start + s[ROWS] * s[INTS]].reshape((s[ROWS], s[INTS]))


@inner
def _floats(p, s):
    start = p.places[P_FLOATS, 0] + s[FLOAT0]
    return p.reals[start : start + s[ROWS] * s[FLOATS]].reshape((s[ROWS], s[FLOATS]))


@inner
def _coefs(coef, s):
    return coef[s[COEF0] : s[COEF0] + s[ROWS] * s[COEFS]].reshape((s[ROWS], s[COEFS]))


@inner
def _terms(p):
    """Rows of terms and of their kernels."""
    return wholes(p, P_TERMS).reshape((-1, SIZES)), wholes(p, P_KERNELS).reshape((-1, KERNELS))


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
    mass = reals(p, P_MASS_DATA)
    for i in range(data.size):
        data[i] = cM * mass[i]
    tangents(p, y, v, coef, -1, cK, cC, data)


@njit(cache=True, error_model="numpy")
def tangents(p, y, v, coef, role, cK, cC, data):
    """Add cK K + cC C, and Phi_q and its transpose, of all terms of a role (-1: all)."""
    slots = wholes(p, P_SLOTS)
    terms, kernels = _terms(p)
    for k in range(len(terms)):
        s = terms[k]
        if role < 0 or s[ROLE] == role:
            end = s[SLOT0] + s[SPREADS] * s[ENTRIES]
            places = slots[s[SLOT0] : end].reshape((s[SPREADS], s[ENTRIES]))
            tangent_at(kernels[k, TANGENT])(
                y, v, _coefs(coef, s), _ints(p, s), _floats(p, s), cK, cC, places, data
            )


@njit(cache=True, error_model="numpy")
def energies(p, y, v, coef, out):
    """Overwrite ``out`` (4,): energy of bodies, of contacts, power lost, power on free strains."""
    fill(out, 0.0)
    one = np.zeros(3)
    terms, kernels = _terms(p)
    for k in range(len(terms)):
        s = terms[k]
        if kernels[k, ENERGY] != 0:
            fill(one, 0.0)
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


@inner
def remember(p, w):
    """Histories at the end of the step of all contacts whose friction has a memory."""
    terms, kernels = _terms(p)
    history, coef = reals(w, HISTORY0).reshape((-1, HISTORIES)), reals(w, COEF)
    starts = wholes(p, P_CONTACT_AT)
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
                reals(w, Y1_), reals(w, V1_), _coefs(reals(w, COEF), s), _ints(p, s),
                _floats(p, s), history[s[CONTACT0] : s[CONTACT0] + s[CONTACTS]],
            )  # fmt: skip


@njit(cache=True, error_model="numpy")
def inertia(p, a, out):
    """out (n,) = M a; a number of M stands for the x, y and z of two vectors where it can."""
    rows, columns = wholes(p, P_MASS_ROWS), wholes(p, P_MASS_COLUMNS)
    mass, spatial = reals(p, P_MASS), p.ints[4] == 3
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
    at = wholes(p, P_SIGNALS)
    if at.size:
        signals_at(wholes(p, P_SIGNAL)[0])(t, np.int64(values.ctypes.data))
        for i in range(at.size):
            coef[at[i]] = values[i]


@inner
def coefficients(p, w, t):
    """Coefficients at time ``t``, linear inside the window."""
    coef, c0, c1, span = reals(w, COEF), reals(w, C0), reals(w, C1), reals(w, SPAN)
    if c1.size:
        s = (t - span[0]) / span[2]
        for i in range(c0.size):
            coef[i] = c0[i] + s * (c1[i] - c0[i])
    write_signals(p, t, reals(w, VALUES), coef)


@njit(cache=True, error_model="numpy")
def instant(y, v, scale):
    """Time step [s] for differences along the motion: a ten thousandth of its own time.

    scale : (n,) float  size of each coordinate
    """
    far, fast = 0.0, 0.0
    for i in range(scale.size):
        far, fast = max(far, abs(y[i]) / scale[i]), max(fast, abs(v[i]) / scale[i])
    return 1e-4 * (1.0 + far) / (1.0 + fast)
