"""How regular a phase portrait is, in numbers: published measures of chaos, order and spread.

None of them settles the matter alone, so that each portrait has all of them:

- the 0-1 test for chaos (Gottwald & Melbourne, SIAM J. Appl. Dyn. Syst. 8, 2009, 129-145): near 0
  for regular motion, near 1 for chaos and for noise;
- permutation entropy (Bandt & Pompe, Phys. Rev. Lett. 88, 2002, 174102): how many of the possible
  rankings of successive values occur, 1 for white noise;
- the largest Lyapunov exponent of the time series (Rosenstein, Collins & De Luca, Physica D 65,
  1993, 117-134);
- spectral flatness (Gray & Markel, IEEE Trans. ASSP 22, 1974, 207-217): geometric over arithmetic
  mean of the spectrum, 0 for lines;
- the spread of stroboscopic points at every phase of a drive, and after how many of its periods
  they come back.

With a drive, chaos is that of what remains when the mean over its periods has been taken off: the
drive itself is regular, and slow beside what impacts do. The 0-1 test takes any observable
(Gottwald & Melbourne 2009, section 2); here it is the change from sample to sample, in which slow
motion does not hide what is fast.

They are free of scale: a joint that is locked leaves round-off, which is irregular. Read them
together with the extent of the portrait.
"""

from math import factorial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FEWEST = 200
"""Fewest samples, a decorrelation time apart, for the 0-1 test; 157 of two tones look chaotic."""
ORDER = 5
"""Values in a ranking of the permutation entropy."""
FREQUENCIES = 100
"""Random frequencies of the 0-1 test, of whose answers the median counts."""
MOST_PERIODS = 8
"""Periods of the drive after which a motion may come back."""
CLOSED = 0.05
"""Spread of stroboscopic points, relative to the portrait, below which they come back."""
MOST_REFERENCES, MOST_CANDIDATES = 400, 4000
"""Points whose neighbours are followed, and points among which they are sought."""


class Regularity(NamedTuple):
    """Numbers of a phase portrait; nan where the samples do not suffice.

    chaos : K of the 0-1 test of y, with a period of what y has besides its mean over the periods:
        near 0 regular, near 1 chaotic or noise
    entropy : permutation entropy of y, from 0 to 1, of five values a decorrelation time apart;
        0.3 to 0.5 for one oscillation, 1 for white noise
    flatness : of the spectrum of those changes, up to the decorrelation frequency: 0 lines, 1 if it
        is even; 0.48 for white noise, whose changes are not white
    lyapunov : float [1/s]  largest exponent of the divergence of neighbours in the portrait
    spread : of stroboscopic points, relative to the portrait: 0 if every period is like the one
        before, 1 if the drive says nothing about the motion; nan without a period
    periods : of the drive after which the motion comes back; 0: of none up to eight, or no period
    width, height : extents of the portrait, in the units of x and y
    samples : how many changes of y, a decorrelation time apart, the 0-1 test saw
    """

    chaos: float
    entropy: float
    flatness: float
    lyapunov: float
    spread: float
    periods: int
    width: float
    height: float
    samples: int

    @property
    def word(self) -> str:
        """What the 0-1 test says: regular, mixed or irregular; unknown of too few samples."""
        if np.isnan(self.chaos):
            return "unknown"
        return "regular" if self.chaos < 0.3 else "irregular" if self.chaos > 0.7 else "mixed"


def regularity(t: Array, x: Array, y: Array, period: float | None = None) -> Regularity:
    """Measures of the regularity of a phase portrait.

    Parameters
    ----------
    t : (n,) float [s]  increasing; values at uneven times are interpolated to even ones
    x, y : (n,) float  the portrait, such as angle [rad] and angular velocity [rad/s]
    period : float [s]  of a drive, for stroboscopic points

    Returns
    -------
    Regularity

    Raises
    ------
    ValueError
        The arrays differ in length, or are shorter than 16.
    """
    t, x, y = evenly(np.asarray(t, float), np.asarray(x, float), np.asarray(y, float))
    width, height = float(np.ptp(x)), float(np.ptp(y))
    x = without_trend(x)
    spread, periods, rest = (np.nan, 0, y) if period is None else stroboscopic(t, x, y, period)
    if height <= 1e-14 * max(1.0, np.abs(y).max()):
        return Regularity(0.0, 0.0, 0.0, 0.0, spread, periods, width, height, len(y))
    delay = decorrelation(y)
    changes = np.diff(rest)
    sparse = changes[:: decorrelation(changes)]
    return Regularity(
        chaos=0.0 if periods == 1 else chaos(sparse) if len(sparse) >= FEWEST else np.nan,
        entropy=permutation_entropy(y, ORDER, delay),
        flatness=spectral_flatness(sparse),
        lyapunov=lyapunov(t[1] - t[0], np.column_stack([x, y]), delay),
        spread=spread,
        periods=periods,
        width=width,
        height=height,
        samples=len(sparse),
    )


def evenly(t: Array, x: Array, y: Array) -> tuple[Array, Array, Array]:
    """The same at even times."""
    if not len(t) == len(x) == len(y):
        raise ValueError(f"t, x and y have {len(t)}, {len(x)} and {len(y)} values")
    if len(t) < 16:
        raise ValueError(f"a portrait of {len(t)} samples: too short, at least 16 are needed")
    even = np.linspace(t[0], t[-1], len(t))
    if np.abs(even - t).max() <= 1e-6 * (t[1] - t[0]):
        return even, x, y
    return even, np.interp(even, t, x), np.interp(even, t, y)


def without_trend(x: Array) -> Array:
    """Values less the straight line through them."""
    steps = np.arange(len(x)) - 0.5 * (len(x) - 1)
    slope = steps @ x / (steps @ steps) if len(x) > 1 else 0.0
    result: Array = x - x.mean() - slope * steps
    return result


def decorrelation(y: Array) -> int:
    """Samples until the autocorrelation first is zero: a quarter of a period of an oscillation.

    Closer samples make every motion look regular to the 0-1 test (Gottwald & Melbourne 2009,
    section 6).
    """
    centred = y - y.mean()
    spectrum = np.abs(np.fft.rfft(centred, 2 * len(y))) ** 2
    correlation = np.fft.irfft(spectrum)[: len(y) // 2]
    below = np.flatnonzero(correlation <= 0.0)
    return max(1, int(below[0]) if len(below) else len(y) // 2)


# ------------------------------------------------------------------------------------ 0-1 test


def chaos(phi: Array, seed: int = 1) -> float:
    """K of the 0-1 test: near 0 for regular motion, near 1 for chaos.

    Gottwald & Melbourne (2009), section 3: the correlation, with time, of the mean square
    displacement of p + iq = sum phi(j) exp(i c j); median over frequencies c between pi/5 and
    4 pi/5. The term that oscillates with c goes with the mean of phi, which is taken off first.

    Parameters
    ----------
    phi : (n,) float  samples that are not closer than a decorrelation time
    seed : of the frequencies
    """
    n = len(phi)
    lags = np.arange(1, n // 10 + 1)
    c = np.random.default_rng(seed).uniform(0.2 * np.pi, 0.8 * np.pi, (FREQUENCIES, 1))
    walk = np.cumsum((phi - phi.mean()) * np.exp(1j * c * np.arange(1, n + 1)), axis=1)
    moved = _mean_square(walk, lags)
    return float(np.median([_correlation(lags, row) for row in moved]))


def _mean_square(walk: NDArray[np.complex128], lags: NDArray[np.int64]) -> Array:
    """(c, lags) mean square displacement over the same starts for every lag, by FFT."""
    n = walk.shape[1]
    starts = n - int(lags[-1])
    first, size = walk[:, :starts], 2 * n
    product = np.fft.fft(walk, size) * np.conj(np.fft.fft(first, size))
    cross = np.fft.ifft(product)[:, lags].real
    total = np.cumsum(np.pad(np.abs(walk) ** 2, ((0, 0), (1, 0))), axis=1)
    moving = total[:, lags + starts] - total[:, lags]
    result: Array = (moving + total[:, starts : starts + 1] - 2.0 * cross) / starts
    return result


def _correlation(lags: NDArray[np.int64], moved: Array) -> float:
    """Of the displacement with time; 0 where it does not change."""
    if np.ptp(moved) == 0.0:
        return 0.0
    return float(np.corrcoef(lags, moved)[0, 1])


# ------------------------------------------------------------------------------- order, spectrum


def permutation_entropy(y: Array, order: int = ORDER, delay: int = 1) -> float:
    """Entropy of the rankings of ``order`` values ``delay`` apart, over that of equal shares.

    Bandt & Pompe (2002). nan where there are fewer rankings than possible ones.
    """
    count = len(y) - (order - 1) * delay
    if count < factorial(order):
        return np.nan
    rows = np.column_stack([y[k * delay : k * delay + count] for k in range(order)])
    ranks = np.argsort(rows, axis=1, kind="stable") @ order ** np.arange(order)
    shares = np.unique(ranks, return_counts=True)[1] / count
    return float(-(shares @ np.log(shares)) / np.log(factorial(order)))


def spectral_flatness(y: Array, segments: int = 8) -> float:
    """Geometric over arithmetic mean of the spectrum (Gray & Markel 1974), averaged by Welch.

    Of white noise it is exp(psi(k))/k with k averages: 0.94 for eight.
    """
    length = len(y) // segments
    if length < 8:
        return np.nan
    rows = y[: segments * length].reshape(segments, length)
    rows = (rows - y.mean()) * np.hanning(length)
    power = (np.abs(np.fft.rfft(rows)) ** 2).mean(axis=0)[1:-1]
    if power.min() <= 0.0:
        return 0.0
    return float(np.exp(np.log(power).mean()) / power.mean())


# ------------------------------------------------------------------------------------ divergence


def lyapunov(step: float, portrait: Array, delay: int) -> float:
    """Largest Lyapunov exponent [1/s] of a sampled motion.

    Rosenstein, Collins & De Luca (1993): the mean logarithm of the distance of nearest neighbours
    that do not belong to the same turn, over the time that they have been followed; its slope up to
    half of the way to where distances saturate.

    Parameters
    ----------
    step : float [s]  between samples
    portrait : (n, k) float  columns of any units
    delay : samples between the two states that make a point of the reconstruction
    """
    size = portrait.std(axis=0)
    states = (portrait - portrait.mean(axis=0)) / np.where(size > 0.0, size, 1.0)
    points = np.column_stack([states[:-delay], states[delay:]])
    follow = min(8 * delay, len(points) // 4)
    if follow < 4 or len(points) < 10 * delay:
        return np.nan
    one, other = _neighbours(points, 4 * delay, follow)
    k = np.arange(follow)
    apart = np.linalg.norm(points[one[:, None] + k] - points[other[:, None] + k], axis=2)
    return _slope(_mean_logarithm(apart), _mean_logarithm(_strangers(points))[0]) / step


def _neighbours(
    points: Array, exclude: int, follow: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Points, and the nearest to each that are not on the same turn; both can be followed."""
    last = len(points) - follow
    one = np.unique(np.linspace(0, last - 1, min(MOST_REFERENCES, last)).astype(np.int64))
    among = np.unique(np.linspace(0, last - 1, min(MOST_CANDIDATES, last)).astype(np.int64))
    squares = (points**2).sum(axis=1)
    apart = squares[one, None] + squares[among] - 2.0 * points[one] @ points[among].T
    apart[np.abs(one[:, None] - among) < exclude] = np.inf
    found = among[apart.argmin(axis=1)]
    away = np.abs(found - one) >= exclude
    return one[away], found[away]


def _strangers(points: Array) -> Array:
    """(n, 1) distances of points that have nothing to do with one another."""
    mixed = np.random.default_rng(1).permutation(len(points))[: 2 * (len(points) // 2)]
    first, second = np.split(mixed, 2)
    result: Array = np.linalg.norm(points[first] - points[second], axis=1)[:, None]
    return result


def _mean_logarithm(apart: Array) -> Array:
    """Over the pairs; those that coincide would be minus infinity."""
    return np.log(np.maximum(apart, 1e-12)).mean(axis=0)


def _slope(course: Array, saturated: float) -> float:
    """Of the first half of the way to saturation, per sample."""
    half = course[0] + 0.5 * (saturated - course[0])
    beyond = np.flatnonzero(course > half)
    end = max(4, int(beyond[0]) if len(beyond) else len(course))
    return float(np.polyfit(np.arange(end), course[:end], 1)[0])


# ---------------------------------------------------------------------------------- stroboscope


def stroboscopic(t: Array, x: Array, y: Array, period: float) -> tuple[float, int, Array]:
    """Spread of the points seen once in a period of the drive, and periods until they come back.

    Points are seen at every phase of the drive, not at a chosen one.

    Parameters
    ----------
    t : (n,) float [s];  x, y : (n,) float
    period : float [s]

    Returns
    -------
    spread : rms distance from their mean over that of the portrait
    periods : fewest periods after which the points come back, up to eight; 0: they do not
    rest : (m,) float  y less its mean over the periods, in as many whole periods as there are
    """
    count = int((t[-1] - t[0]) / period * (1.0 + 1e-9))
    if count < 3:
        return np.nan, 0, y
    each = max(8, round(period / (t[1] - t[0])))
    times = t[0] + period * np.arange(count * each) / each
    rows = np.stack([np.interp(times, t, row).reshape(count, each) for row in (x, y)])
    scale = rows.std(axis=(1, 2), keepdims=True)
    seen = rows / np.where(scale > 0.0, scale, np.inf)
    rest = (rows[1] - rows[1].mean(axis=0)).ravel()
    for periods in range(1, min(MOST_PERIODS, count // 3) + 1):
        if _spread(seen, periods) < CLOSED:
            return _spread(seen, 1), periods, rest
    return _spread(seen, 1), 0, rest


def _spread(seen: Array, periods: int) -> float:
    """Root of the mean square distance from the mean at the same phase of so many periods.

    seen : (2, count, each)  of x and y
    """
    away = [
        g - g.mean(axis=1, keepdims=True) for g in (seen[:, k::periods] for k in range(periods))
    ]
    free = seen.shape[1] - periods
    squares = sum(float((one**2).sum()) for one in away) / (2 * free * seen.shape[2])
    return squares**0.5
