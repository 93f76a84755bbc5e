"""The table of a face, which conditions and surfaces share."""

from collections.abc import Iterator

from pydantic import Field

from coupling.fields import Table


class FaceTable(Table):
    """A face."""

    body: str | None = Field(default=None, description="name of a [body.NAME]")
    solid: str | None = Field(default=None, description="name of a [thermal.solid.NAME]")
    part: str | None = Field(default=None, description="name of a [thermal.part.NAME] with an area")
    face: str | None = Field(
        default=None,
        description="of a beam or cable 'outer' (default), 'inner', 'start', 'end'; of a shell "
        "'top' or 'bottom'; of a solid a region, default all of its surface",
    )

    @classmethod
    def odd_keys(cls, keys: set[str]) -> Iterator[tuple[str, str]]:
        if len(keys & {"body", "solid", "part"}) != 1:
            yield "", "give one of body, solid, part"
        elif {"part", "face"} <= keys:
            yield "face", "does not go with part: it has one face"
