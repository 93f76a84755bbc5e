"""The sections of the report on the paper, in its order; each is imported when it is made."""

from collections.abc import Callable, Iterator
from importlib import import_module

from coupling.paper.entries import Entry
from coupling.paper.workshop import Workshop

SECTIONS = {
    "claims": "coupling.paper.claims:entries",
    "theory": "coupling.paper.theory:entries",
    "table_1": "coupling.paper.table_1:entries",
    "table_2": "coupling.paper.table_2:entries",
    "table_3": "coupling.paper.table_3:entries",
    "table_4": "coupling.paper.table_4:entries",
    "table_5": "coupling.paper.table_5:entries",
    "arms": "coupling.paper.arms:entries",
    "boom": "coupling.paper.boom:entries",
    "reflector": "coupling.paper.reflector:entries",
    "hinges": "coupling.paper.hinges:entries",
    "slider_crank": "coupling.paper.slider_crank:entries",
    "mast": "coupling.paper.mast:entries",
    "floating_frame": "coupling.paper.floating_frame:entries",
}
"""Name of each section, and the function that yields its entries."""

Make = Callable[[Workshop], Iterator[Entry]]


def load(name: str) -> Make:
    """What yields the entries of a section."""
    module, function = SECTIONS[name].split(":")
    return getattr(import_module(module), function)
