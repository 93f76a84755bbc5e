"""View factors of grey diffuse exchange between flat facets, and round the inside of long tubes.

Facets that see one another freely have exact values but for the tolerance of the integration (see
``thermal.view_factor_kernels``). Where others may come between, the free value is multiplied by
the share of rays that pass, which errs by up to one part in the square root of their number of
the pair, less in sums of many. A pair costs some 3 us, one partly hidden 50 us and, of facets that
are long against their distance, up to ms; who may come between whom is looked up for all triples
of facets, about 1 ns each. Nothing hides but facets that are given.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

TOLERANCE = 1e-10  # of each pair of edges, over the smaller area of the two facets
FLAT = 1e-6  # height of a corner over the plane of the others, over the size of the facet
RAYS = 256
SCALINGS = 100
ROUND_OFF = 1e-15


class Facets(NamedTuple):
    """Flat convex polygons, padded to the same number of corners.

    corners : (n, c, 3) float [m], counts : (n,) intp  corners of each
    planes : (n, 4) float  unit normal and its product with a point of the plane
    centres : (n, 3) float [m], radii : (n,) float [m]  of spheres about the polygons
    areas : (n,) float [m^2]
    owners : (n,) intp  facet, as it was given, that each is part of
    """

    corners: Array
    counts: Indices
    planes: Array
    centres: Array
    radii: Array
    areas: Array
    owners: Indices


def exchange_areas(polygons: Sequence[Array], rays: int = RAYS) -> Array:
    """Area times view factor [m^2] of all pairs of facets, (n, n), symmetric.

    Parameters
    ----------
    polygons : n arrays (c, 3) float [m]  convex, turning about the normal of the side that sees;
        of four corners that are not in one plane, two triangles are made
    rays : between facets that others may hide from one another
    """
    from thermal.view_factor_kernels import exchange

    facets = _facets(polygons)
    size = float(np.linalg.norm(np.ptp(facets.corners.reshape(-1, 3), axis=0)))
    found = exchange(*facets[:-1], 1e-9 * size, TOLERANCE, rays)
    if len(facets.owners) == len(polygons):
        return found
    whole = np.zeros((len(polygons), len(polygons)))
    np.add.at(whole, (facets.owners[:, None], facets.owners[None, :]), found)
    return whole


def view_factors(polygons: Sequence[Array], rays: int = RAYS) -> Array:
    """(n, n)  share of what leaves facet i diffusely that arrives at j; see ``exchange_areas``."""
    return exchange_areas(polygons, rays) / polygon_areas(polygons)[:, None]


def polygon_areas(polygons: Sequence[Array]) -> Array:
    """(n,) [m^2]"""
    return np.array([np.linalg.norm(_vector_area(np.asarray(p, float))) for p in polygons])


def adjusted(exchange: Array, sums: Array) -> Array:
    """Symmetric exchange areas near given ones that have given sums of rows.

    Rows and columns are scaled alike until it is so (Sinkhorn & Knopp 1967): what is zero stays
    zero, and all stays positive. Where no scaling can do it, as of two facets that see but one
    another and have different sums, the last of ``SCALINGS`` is as near as it comes.

    exchange : (n, n) float [m^2], sums : (n,) float [m^2]
    """
    found = exchange.copy()
    for _ in range(SCALINGS):
        rows = found.sum(1)
        scale = np.sqrt(np.divide(sums, rows, out=np.ones_like(rows), where=rows > 0.0))
        found *= scale[:, None] * scale[None, :]
        if np.abs(scale - 1.0).max(initial=0.0) < ROUND_OFF:
            break
    return found


def arc_factors(widths: Array) -> Array:
    """View factors between arcs that make up the inside of a long circular tube.

    By crossed strings (Hottel 1954) of chords, exact: rows sum to one, and widths times factors
    are symmetric.

    Parameters
    ----------
    widths : (n,) float  of the arcs, one after the other, in any unit
    """
    angle = 2.0 * np.pi * np.asarray(widths, float) / np.sum(widths)
    ends = np.concatenate([[0.0], np.cumsum(angle)])
    chord = 2.0 * np.abs(np.sin(0.5 * (ends[:, None] - ends[None, :])))
    crossed = chord[:-1, :-1] + chord[1:, 1:] - chord[1:, :-1] - chord[:-1, 1:]
    # arcs see themselves past their own chord; of others the strings cross on one side or other
    factors = 0.5 * np.abs(crossed) / angle[:, None]
    np.fill_diagonal(factors, 1.0 - 2.0 * np.sin(0.5 * angle) / angle)
    return factors


def _facets(polygons: Sequence[Array]) -> Facets:
    _require_areas(polygons)
    pieces: list[Array] = []
    owners: list[int] = []
    for i, polygon in enumerate(polygons):
        parts = _flat_parts(np.asarray(polygon, float))
        pieces += parts
        owners += [i] * len(parts)
    most = max((len(p) for p in pieces), default=3)
    corners = np.stack([np.vstack([p, np.tile(p[-1:], (most - len(p), 1))]) for p in pieces])
    vectors = np.array([_vector_area(p) for p in pieces])
    areas = np.linalg.norm(vectors, axis=1)
    centres = np.array([p.mean(0) for p in pieces])
    normals = vectors / areas[:, None]
    return Facets(
        corners,
        np.array([len(p) for p in pieces]),
        np.hstack([normals, (normals * centres).sum(1)[:, None]]),
        centres,
        np.linalg.norm(corners - centres[:, None], axis=2).max(1),
        areas,
        np.array(owners),
    )


def _flat_parts(polygon: Array) -> list[Array]:
    """The polygon without corners that coincide, or, of a warped one, a fan of triangles."""
    kept = np.linalg.norm(polygon - np.roll(polygon, 1, axis=0), axis=1) > 0.0
    corners = polygon[kept]
    if len(corners) < 4:
        return [corners]
    vector = _vector_area(corners)
    off = np.abs((corners - corners.mean(0)) @ vector)
    if off.max() <= FLAT * np.linalg.norm(vector) * np.ptp(corners, axis=0).max():
        return [corners]
    return [corners[[0, i, i + 1]] for i in range(1, len(corners) - 1)]


def _vector_area(corners: Array) -> Array:
    if len(corners) < 3:
        return np.zeros(3)
    arms = corners[1:] - corners[0]
    return 0.5 * np.cross(arms[:-1], arms[1:]).sum(0)


def _require_areas(polygons: Sequence[Array]) -> None:
    extents = np.array([np.ptp(np.asarray(p, float), axis=0).max() for p in polygons])
    empty = np.flatnonzero(~(polygon_areas(polygons) > 1e-12 * extents**2))
    if len(empty):
        which = ", ".join(str(k) for k in empty[:5])
        raise ValueError(f"view factors: {len(empty)} facets have no area, among them {which}")
