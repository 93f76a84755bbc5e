"""Heat by a network of lumps and conductances: ``LumpedHeat``.

Finite volumes: every temperature is a lump of wall, joined to its neighbours along the member
and round the circumference by conductances with k at the mean of the two temperatures. It sees
the same description as ``thermal.line`` and shares neither discretisation nor time integration
with it. Over the circumference its error falls with the square of the angle between points.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array

from thermal import trbdf2
from thermal.check import check
from thermal.description import DEFAULT, Description, Settings
from thermal.heat import NOTHING, Outside
from thermal.layout import given, given_nodes, layout
from thermal.network import Network, network

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


class LumpedHeat:
    """Network of heat capacities and conductances; the state is the vector of temperatures.

    Parameters
    ----------
    description : Description
    settings : Settings
    """

    def __init__(self, description: Description, settings: Settings = DEFAULT) -> None:
        check(description)
        self.tolerance = settings.tolerance
        self.x, self.regions, self._initial = layout(description)
        self._given = given(description, self.regions, self.x)
        self.free = np.setdiff1d(np.arange(len(self.x)), given_nodes(self._given))
        self._place = np.full(len(self.x), -1)
        self._place[self.free] = np.arange(len(self.free))
        self._net: Network = network(description, self.regions)

    def initial(self) -> Array:
        """(n,) [K]"""
        return self._initial.copy()

    def energy(self, T: Array) -> float:
        """Stored heat [J] above the materials' datum of enthalpy."""
        return float(self.heat(T).sum())

    def advance(
        self, T: Array, t: float, h: float, heat: Array, outside: Outside = NOTHING
    ) -> tuple[Array, Mapping[str, float], str]:
        """Temperatures at ``t + h``, heat [J] through each boundary, reason; see ThermalSolver."""
        end = trbdf2.integrate(self, T, t, h, heat / h, self.tolerance)
        net = self._net
        names = [r.name for r in net.radiators] + [f.name for f in net.feeds]
        names += [o.name for o in net.outlets]
        flows = dict(zip(names, end.flows.tolist(), strict=True))
        flows.update({g.name: float(end.reactions[g.nodes].sum()) for g in self._given})
        return end.T, flows, end.why

    def impose(self, T: Array, t: float) -> Array:
        """Copy of ``T`` with the prescribed temperatures of time ``t``."""
        T = T.copy()
        for g in self._given:
            T[g.nodes] = g.at(t)
        return T

    def heat(self, T: Array) -> Array:
        """(n,) [J] stored in each lump."""
        out = np.zeros(len(T))
        for s in self._net.substances:
            out[s.nodes] = self._net.mass[s.nodes] * s.material.enthalpy(T[s.nodes])
        return out

    def power(self, T: Array, t: float) -> tuple[Array, Array]:
        """(n,) [W] into each lump, (m,) [W] through each boundary."""
        net, flows = self._net, []
        q = net.shape * self._conductivity(T)[0] * (T[net.a] - T[net.b])
        out = np.zeros(len(T))
        out += np.bincount(net.b, q, len(T)) - np.bincount(net.a, q, len(T))
        for r in net.radiators:
            p = r.strength * (r.sink(t) ** 4 - T[r.nodes] ** 4)
            out[r.nodes] += p
            flows.append(p.sum())
        for feed in net.feeds:
            p = feed.loads * feed.history(t)
            out[feed.nodes] += p
            flows.append(p.sum())
        for o in net.outlets:
            flows.append(o.conductance * (o.history(t) - T[o.nodes].mean()))
            out[o.nodes] += flows[-1] / len(o.nodes)
        for c in net.bridges:
            flow = c.conductance * (T[c.b].mean() - T[c.a].mean())
            out[c.a] += flow / len(c.a)
            out[c.b] -= flow / len(c.b)
        return out, np.array(flows, dtype=float)

    def jacobian(self, T: Array, tau: float) -> csc_array:
        """dE/dT - tau dF/dT of the free lumps."""
        net, n = self._net, len(self.free)
        k, slope = self._conductivity(T)
        bend = 0.5 * slope * (T[net.a] - T[net.b])
        to_a, to_b = tau * net.shape * (k + bend), tau * net.shape * (k - bend)
        diagonal = self._capacity(T)
        for r in net.radiators:
            diagonal[r.nodes] += 4.0 * tau * r.strength * T[r.nodes] ** 3
        every = np.arange(len(T))
        rows = np.concatenate([every, net.a, net.a, net.b, net.b, net.link_rows])
        columns = np.concatenate([every, net.a, net.b, net.b, net.a, net.link_columns])
        values = np.concatenate([diagonal, to_a, -to_b, to_b, -to_a, tau * net.link_values])
        i, j = self._place[rows], self._place[columns]
        kept = (i >= 0) & (j >= 0)
        return coo_array((values[kept], (i[kept], j[kept])), shape=(n, n)).tocsc()

    def fault(self, T: Array) -> str:
        """Which lump has left the range of a property, or ""."""
        found = [(T < 0.0, "fell below 0 K")]
        for s in self._net.substances:
            for p, nodes in s.needs:
                out = np.zeros(len(T), dtype=bool)
                out[nodes] = (T[nodes] < p.lower * (1 - 1e-9)) | (T[nodes] > p.upper * (1 + 1e-9))
                found.append((out, f"left the range of {p.name} ({p.lower:g} K to {p.upper:g} K)"))
        for out, why in found:
            if out.any():
                node = int(np.argmax(out))
                owner = next(name for name, nodes in self.regions.items() if node in nodes)
                return f"'{owner}' {why} with {T[node]:g} K"
        return ""

    def _conductivity(self, T: Array) -> tuple[Array, Array]:
        """k and dk/dT of every conductor at its mean temperature."""
        net = self._net
        mean = 0.5 * (T[net.a] + T[net.b])
        k, slope = np.zeros(len(mean)), np.zeros(len(mean))
        for s in net.substances:
            k[s.conductors] = s.material.conductivity(mean[s.conductors])
            slope[s.conductors] = s.material.conductivity.derivative(mean[s.conductors])
        return k, slope

    def _capacity(self, T: Array) -> Array:
        """(n,) [J/K]"""
        out = np.zeros(len(T))
        for s in self._net.substances:
            out[s.nodes] = self._net.mass[s.nodes] * s.material.heat_capacity(T[s.nodes])
        return out
