"""A scene with the changes of its [variant.NAME] tables."""

import tomllib
from collections.abc import Sequence

from coupling import casefile
from coupling.scene import Scene
from coupling.variant_tables import chosen


def with_variants(scene: Scene, names: Sequence[str]) -> Scene:
    """The scene with named variants of it, one after the other.

    Raises
    ------
    BadCase : a variant does not fit
    """
    if not names:
        return scene
    made = chosen(tomllib.loads(scene.text), names, str(scene.folder))
    return casefile.from_text(scene.text, scene.folder, made)
