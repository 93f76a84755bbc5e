"""A ring truss that folds: perimeter truss of an even number of panels, as plain data.

Posts (battens) stand upright on a circle. Neighbouring posts are joined by two chords of one
length, hinged at both ends about the outward normal of their panel: a parallelogram. Neighbouring
panels shear in opposite senses, so posts go up and down by turns, all chords have the same slope
θ, and the polygon shrinks by cos θ (the fraction that is deployed):

    R(θ) = D/2 cos θ,   z_k = (-1)^k L/2 sin θ,   L = D sin(π / bays)

Parallelograms only shift posts, hence no post ever turns and panels keep their angle 2π/bays: with
rigid members the ring has bays - 3 ways to move. Wheels at the lower ends of the posts that turn
the chords on both sides by opposite angles leave one. The long diagonal of each panel is a tube in
a tube; a rope runs through all of them from post to post, up and down by turns, and deploys the
ring as it becomes shorter (perimeter truss of the AstroMesh kind: Thomson 2000, IUTAM-IASS
Symposium on Deployable Structures, "AstroMesh deployable reflectors for Ku- and Ka-band").
"""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
End = Literal["start", "end"]

SHARE = 0.55
"""Length of each tube of a diagonal, of the longest that the diagonal can become [-]."""


class Form(NamedTuple):
    """Even number of panels; diameter of the deployed circle of posts, height of posts [m]."""

    bays: int
    diameter: float
    height: float

    @property
    def chord(self) -> float:
        """Length of a chord [m]."""
        return float(self.diameter * np.sin(np.pi / self.bays))

    @property
    def tube(self) -> float:
        """Length of each of the two tubes of a diagonal [m]."""
        return SHARE * (self.chord + self.height)

    def diagonal(self, slope: float) -> float:
        """Length of the long diagonal [m] of a panel whose chords have a slope [rad]."""
        L, H = self.chord, self.height
        return float(np.sqrt(L**2 + H**2 + 2.0 * L * H * np.sin(slope)))

    def lever(self, slope: float) -> float:
        """By how much the diagonal becomes longer with the slope of the chords [m/rad]."""
        return float(self.chord * self.height * np.cos(slope) / self.diagonal(slope))

    def swing(self, slope: float) -> float:
        """By what angle the diagonal turns while chords turn by one [-]."""
        L, H = self.chord, self.height
        return float(L * (L + H * np.sin(slope)) / self.diagonal(slope) ** 2)

    def rope(self, slope: float) -> float:
        """Length of the rope through all diagonals [m]."""
        return self.bays * self.diagonal(slope)


class Bar(NamedTuple):
    """A straight member from ``start`` to ``end``, (3,) [m].

    normal : (3,) float  direction of e2: outward, normal to the panel (posts: radial)
    angle : float [rad]  of its middle around the ring
    """

    name: str
    kind: Literal["chord", "batten", "outer", "inner"]
    start: Array
    end: Array
    normal: Array
    angle: float


class Corner(NamedTuple):
    """An end of a post."""

    post: str
    at: End


class Panel(NamedTuple):
    """What lies between one post and the next.

    lower, upper, outer, inner : names of its members
    foot, head : corners from which the outer tube goes to the inner one
    normal, along : (3,) float  outward, and level towards the next post
    axis : (3,) float  direction of the diagonal from foot to head
    turn : float [rad]  by which its chords turn about the normal until the ring is deployed
    """

    lower: str
    upper: str
    outer: str
    inner: str
    near: str
    far: str
    foot: Corner
    head: Corner
    normal: Array
    along: Array
    axis: Array
    turn: float


class Ring(NamedTuple):
    """Members, panels in order, and the way of the rope from corner to corner, closed."""

    bars: list[Bar]
    panels: list[Panel]
    rope: list[Corner]


def slope_of(fraction: float) -> float:
    """Slope of the chords [rad] at a deployed fraction of the diameter, (0, 1]."""
    if not 0.0 < fraction <= 1.0:
        raise ValueError(f"the deployed fraction must be above 0 and at most 1, got {fraction:g}")
    return float(np.arccos(fraction))


def corners(form: Form, slope: float) -> Array:
    """(2, bays, 3) lower and upper ends of the posts [m], about the axis z of the ring."""
    k = np.arange(form.bays)
    angle = 2.0 * np.pi * k / form.bays
    radius = 0.5 * form.diameter * np.cos(slope)
    rise = 0.5 * form.chord * np.sin(slope) * (-1.0) ** k
    low = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), rise])
    return np.stack([low, low + np.array([0.0, 0.0, form.height])])


def held_corners(form: Form, slope: float, start: float) -> Array:
    """``corners`` of a ring whose first post stays where it is at the slope ``start``."""
    return corners(form, slope) + (corners(form, start) - corners(form, slope))[:, :1]


def deployable_ring(form: Form, fraction: float) -> Ring:
    """The ring with ``fraction`` of its diameter deployed.

    Raises
    ------
    ValueError : for an odd number of panels or fewer than 4, and a fraction outside (0, 1]
    """
    if form.bays < 4 or form.bays % 2:
        raise ValueError(f"a ring that folds needs an even number of bays from 4 on, {form.bays=}")
    slope = slope_of(fraction)
    ends = corners(form, slope)
    width = len(str(form.bays - 1))
    names = [f"{k:0{width}d}" for k in range(form.bays)]
    posts = [_post(k, names[k], ends[:, k], form) for k in range(form.bays)]
    bars, panels = list(posts), []
    for k, name in enumerate(names):
        after = (k + 1) % form.bays
        panel = _panel(k, (name, names[after]), ends[:, [k, after]], slope)
        panels.append(panel)
        bars += _bars(panel, ends[:, [k, after]], form, 2.0 * np.pi * (k + 0.5) / form.bays)
    way = [panel.foot for panel in panels]
    return Ring(bars, panels, [*way, way[0]])


def _post(k: int, name: str, ends: Array, form: Form) -> Bar:
    angle = 2.0 * np.pi * k / form.bays
    radial = np.array([np.cos(angle), np.sin(angle), 0.0])
    return Bar(f"batten_{name}", "batten", ends[0], ends[1], radial, angle)


def _panel(k: int, names: tuple[str, str], ends: Array, slope: float) -> Panel:
    """``ends`` (2, 2, 3): lower and upper ends of this post and of the next."""
    near, far = (f"batten_{name}" for name in names)
    down = k % 2 == 0  # from a raised post to a lowered one
    foot, head = (Corner(near, "end" if down else "start"), Corner(far, "start" if down else "end"))
    along = ends[0, 1] - ends[0, 0]
    along = np.array([along[0], along[1], 0.0]) / np.hypot(along[0], along[1])
    normal = np.cross(along, [0.0, 0.0, 1.0])
    axis = ends[int(not down), 1] - ends[int(down), 0]
    own = names[0]
    return Panel(
        f"chord_low_{own}", f"chord_up_{own}", f"outer_{own}", f"inner_{own}",
        near, far, foot, head, normal, along, axis / np.linalg.norm(axis),
        slope if down else -slope,
    )  # fmt: skip


def _bars(panel: Panel, ends: Array, form: Form, angle: float) -> list[Bar]:
    foot = ends[int(panel.foot.at == "end"), 0]
    head = ends[int(panel.head.at == "end"), 1]
    mouth, slider = foot + form.tube * panel.axis, head - form.tube * panel.axis
    return [
        Bar(panel.lower, "chord", ends[0, 0], ends[0, 1], panel.normal, angle),
        Bar(panel.upper, "chord", ends[1, 0], ends[1, 1], panel.normal, angle),
        Bar(panel.outer, "outer", foot, mouth, panel.normal, angle),
        Bar(panel.inner, "inner", slider, head, panel.normal, angle),
    ]
