"""A ring truss from a few numbers: the deployed rim of a large mesh reflector, as plain data.

Posts (battens) stand on a circle. Between neighbouring posts lies a flat panel of a lower chord, an
upper chord and a diagonal. At each of the 2 x bays corners the end of the post is the corner, and
three other members are hinged to it:

- a chord by a revolute at its start and a spherical hinge at its end,
- a diagonal by revolutes at both ends,

all revolutes about the normal of the panel. So each bay has 4 members, 4 revolutes and 2 spherical
hinges; no member can spin about its own axis, and no post about its own: panels fold against each
other only by bending their diagonals. Every member brings its own nodes, hence no hinge repeats
what another holds.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

START, END = "start", "end"
LEVELS = {1: 2, 2: 4, 3: 8, 4: 16}
"""Elements of the span of a member, by level of refinement; the fitting is one more."""


class Member(NamedTuple):
    """A straight member.

    points : (n, 3) float [m]  nodes: of the fitting at the start, then of the span
    normal : (3,) float  direction of e2: outward, normal to the panel (posts: radial)
    angle : float [rad]  of its middle around the ring, 0 to 2 pi
    """

    name: str
    kind: str
    points: Array
    normal: Array
    angle: float


class Hinge(NamedTuple):
    """Member ``a`` hangs by its end ``at`` on the end ``base_at`` of the post ``base``.

    axis : (3,) float of a revolute, None: spherical
    """

    name: str
    a: str
    at: str
    base: str
    base_at: str
    axis: Array | None


class Truss(NamedTuple):
    """Members, hinges, and the (post, end) of each corner: lower ones first, around the ring."""

    members: list[Member]
    hinges: list[Hinge]
    corners: list[tuple[str, str]]

    @property
    def elements(self) -> int:
        """Number of elements."""
        return sum(len(m.points) - 1 for m in self.members)

    @property
    def nodes(self) -> int:
        """Number of nodes: hinged members share none."""
        return sum(len(m.points) for m in self.members)


def ring_truss(
    bays: int = 36,
    diameter: float = 100.0,
    height: float = 6.0,
    elements: int = 8,
    fitting: float = 0.3,
) -> Truss:
    """Ring of ``bays`` panels about the z axis, lower corners at z = 0.

    Parameters
    ----------
    diameter, height : float [m]  of the circle of the posts; of the posts
    elements : of the span of a member, all of one length
    fitting : float [m]  length of one more element, at the start of each member; 0: none
    """
    if bays < 3:
        raise ValueError(f"ring truss: needs at least 3 bays, got {bays}")
    low = _circle(bays, 0.5 * diameter)
    up = low + np.array([0.0, 0.0, height])
    shortest = min(height, float(np.linalg.norm(low[1] - low[0])))
    if not (0.0 <= fitting < shortest and elements >= 1):
        text = f"between 0 and the shortest member, {shortest:g} m, got {fitting:g} m"
        raise ValueError(f"ring truss: the fitting must be {text}")
    members, hinges = [], []
    width = len(str(bays - 1))
    for k in range(bays):
        after = (k + 1) % bays
        this, following = f"{k:0{width}d}", f"{after:0{width}d}"
        panel = _outward(low[k] + low[after])
        middle = 2.0 * np.pi * (k + 0.5) / bays
        spans = {
            "chord_low": (low[k], low[after], panel, middle),
            "chord_up": (up[k], up[after], panel, middle),
            "batten": (low[k], up[k], _outward(low[k]), 2.0 * np.pi * k / bays),
            "diagonal": (low[k], up[after], panel, middle),
        }
        for kind, (a, b, normal, angle) in spans.items():
            nodes = _nodes(a, b, elements, fitting)
            members.append(Member(f"{kind}_{this}", kind, nodes, normal, angle))
        hinges += _hinges(this, following, panel)
    posts = [m.name for m in members if m.kind == "batten"]
    return Truss(members, hinges, [(name, at) for at in (START, END) for name in posts])


def _circle(count: int, radius: float) -> Array:
    angle = 2.0 * np.pi * np.arange(count) / count
    return radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])


def _outward(point: Array) -> Array:
    return point / np.linalg.norm(point)


def _nodes(start: Array, end: Array, elements: int, fitting: float) -> Array:
    length = float(np.linalg.norm(end - start))
    along = np.linspace(fitting / length, 1.0, elements + 1)
    if fitting > 0.0:
        along = np.concatenate([[0.0], along])
    nodes = start + along[:, None] * (end - start)
    nodes[-1] = end
    return nodes


def _hinges(this: str, following: str, panel: Array) -> list[Hinge]:
    """The six hinges of the panel between two posts."""
    near, far = f"batten_{this}", f"batten_{following}"
    found = []
    for kind, at, base, base_at, turns in (
        ("chord_low", START, near, START, True),
        ("chord_low", END, far, START, False),
        ("chord_up", START, near, END, True),
        ("chord_up", END, far, END, False),
        ("diagonal", START, near, START, True),
        ("diagonal", END, far, END, True),
    ):
        name, axis = f"{kind}_{this}", panel if turns else None
        found.append(Hinge(f"{name}_{at}", name, at, base, base_at, axis))
    return found


def loaded_corners(corners: int, count: int) -> list[int]:
    """``count`` of the corners, evenly spread over the lower and then the upper ones."""
    return [round((i + 0.5) * corners / count - 0.5) for i in range(count)]
