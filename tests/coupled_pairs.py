"""Small equations of heat and motion whose exchange has a known answer."""

from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.sparse import csr_array

from coupling.manager import Pair, initial
from coupling.transfer import Transfer

CAPACITY, LOSS, OUTSIDE, START = 2.0, 0.6, 10.0, 10.5
END = 2.0


def resistance(T):
    """Drag [N s/m] that falls with temperature."""
    return 3.0 * np.exp(-0.3 * (T - OUTSIDE))


def push(t):
    return 4.0 + 3.0 * np.sin(2.0 * t)


class Cup:
    """C T' = loss (outside - T) + heat/h, solved exactly."""

    x = np.zeros((1, 3))
    regions = MappingProxyType({"slider": np.array([0])})

    def initial(self):
        return np.array([START])

    def energy(self, T):
        return CAPACITY * float(T[0])

    def advance(self, T, t, h, heat, outside=None):
        settled = OUTSIDE + heat / h / LOSS
        end = settled + (T - settled) * np.exp(-LOSS / CAPACITY * h)
        return end, {"air": CAPACITY * float((end - T)[0]) - float(heat[0])}, ""


class Sliding(NamedTuple):
    t: float
    v: float
    lost: float


class Slider:
    """v' = push - r(T) v with T linear over the window; r v^2 becomes heat."""

    x = np.zeros((1, 3))
    axes = np.zeros((1, 3, 3))
    regions = MappingProxyType({"slider": np.array([0])})

    def initial(self, T):
        return Sliding(0.0, 1.0, 0.0)

    def advance(self, state, h, T0, T1, observe=None):
        def rates(t, y):
            s = (t - state.t) / h
            r = resistance((1.0 - s) * T0[0, 0] + s * T1[0, 0])
            return [push(t) - r * y[0], r * y[0] ** 2]

        end = solve_ivp(rates, (state.t, state.t + h), [state.v, 0.0], rtol=1e-11, atol=1e-13)
        v, lost = end.y[:, -1]
        return Sliding(state.t + h, v, state.lost + lost), np.array([lost]), ""


def pair():
    read = csr_array(np.array([[1.0], [0.0], [0.0]]))
    return Pair(Cup(), Slider(), Transfer(read, np.zeros((1, 3))))


def exact():
    """Speed and temperature at the end, both equations solved together."""

    def rates(t, y):
        r = resistance(y[1])
        return [push(t) - r * y[0], (LOSS * (OUTSIDE - y[1]) + r * y[0] ** 2) / CAPACITY]

    return solve_ivp(rates, (0.0, END), [1.0, START], rtol=1e-12, atol=1e-12).y[:, -1]


def run(scheme, windows, solvers=None):
    solvers = solvers or pair()
    state, h = initial(solvers), END / windows
    for k in range(windows):
        new, why = scheme(solvers, state, k * h, h, None)
        assert why == ""
        state = new
    return state


class Wells:
    """n lumps of capacity 1 J/K that only receive heat."""

    def __init__(self, n):
        self.x, self.regions = np.zeros((n, 3)), {"wells": np.arange(n)}

    def initial(self):
        return np.full(len(self.x), 300.0)

    def energy(self, T):
        return float(T.sum())

    def advance(self, T, t, h, heat, outside=None):
        return T + heat, {}, ""


class Springs:
    """Releases heat p h + G (T1 - 300): what a window's exchange does has the matrix G."""

    def __init__(self, gains, power):
        self.gains, self.power, self.calls = np.asarray(gains, float), power, 0
        self.x, self.axes = np.zeros((len(power), 3)), np.zeros((len(power), 3, 3))
        self.regions = {"wells": np.arange(len(power))}

    def initial(self, T):
        return 0.0

    def advance(self, state, h, T0, T1, observe=None):
        self.calls += 1
        if observe is not None:
            observe(("pass", self.calls))
        return state + h, h * self.power + self.gains @ (T1[:, 0] - 300.0), ""


def linear_pair(gains, power=None):
    """A pair whose window of length h ends at T with (1 - G)(T - 300) = h p."""
    n = len(gains)
    power = np.linspace(1.0, 2.0, n) if power is None else power
    read = np.zeros((3 * n, n))
    read[0::3] = np.eye(n)
    return Pair(Wells(n), Springs(gains, power), Transfer(csr_array(read), np.zeros((n, 3))))


def solution(solvers, h):
    """(n,) [K] at the end of the first window, exchanged implicitly."""
    G, p = solvers.motion_solver.gains, solvers.motion_solver.power
    return 300.0 + np.linalg.solve(np.eye(len(p)) - G, h * p)
