"""Facets of solid bodies as faces and places."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from meshes.families import CORNERS
from thermal.discretisation import Block, Face, Mean
from thermal.solid_bodies import Body, Filling
from thermal.solid_elements import STORAGE, SURFACE, shape
from thermal.solid_skin import Cells
from thermal.solid_terms import volumes

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

OUTER = "outer"


def facets(body: Body, name: str) -> Cells:
    """Facets of a named region, or of all of the boundary; nodes by facet family.

    "outer" is all of the boundary unless the mesh has a region of that name.
    """
    if name not in body.named:
        if name == OUTER:
            return body.skin.facets
        known = ", ".join(f"'{n}'" for n in (OUTER, *body.named))
        raise ValueError(f"'{body.name}' has no face '{name}'; it has {known}")
    own, missing = body.skin.found(body.named[name])
    if missing:
        raise ValueError(
            f"region '{name}' of '{body.name}': {missing} of its facets are no faces of volume "
            "cells on the boundary"
        )
    return own


def blocks(x: Array, own: Cells, what: str) -> Face:
    """Facets with their points, areas and normals.

    what : the face in words, for one without area
    """
    found = [_block(x, family, nodes) for family, nodes in own.items()]
    least = min((float(b.areas.min()) for b in found), default=0.0)
    if not least > 0.0:
        raise ValueError(f"{what} has facets without area" if found else f"{what} has no area")
    return found


def _block(x: Array, family: str, nodes: Indices) -> Block:
    form = shape(family, SURFACE[family])
    points = x[nodes]
    a, b = (np.einsum("qn,gni->gqi", form.slopes[:, :, i], points) for i in range(2))
    normals = np.cross(a, b)
    size = np.linalg.norm(normals, axis=2)
    return Block(
        nodes,
        form.values,
        size * form.weights,
        np.einsum("qn,gni->gqi", form.values, points),
        normals / np.maximum(size, 1e-300)[..., None],
        points[:, : CORNERS[family]],
    )


def face_mean(face: Face) -> Mean:
    """Mean over a face, with all of its nodes."""
    return _mean([(block.dofs, block.areas @ block.values) for block in face])


def volume_mean(x: Array, cells: Mapping[str, Indices], like: Filling) -> Mean:
    """Mean over cells, with all of their nodes."""
    parts = []
    for family, nodes in cells.items():
        filling = like._replace(family=family, cells=nodes)
        parts.append((nodes, volumes(filling, x) @ shape(family, STORAGE[family]).values))
    return _mean(parts)


def _mean(parts: list[tuple[Indices, Array]]) -> Mean:
    dofs = np.concatenate([d.ravel() for d, _ in parts])
    shares = np.concatenate([s.ravel() for _, s in parts])
    nodes, place = np.unique(dofs, return_inverse=True)
    weights = np.bincount(place, weights=shares)
    return Mean(nodes, weights / weights.sum())
