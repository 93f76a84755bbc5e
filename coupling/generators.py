"""What [generate.NAME] can be, by its kind."""

from typing import Annotated, Any, get_args

from pydantic import Field, TypeAdapter

from coupling.deployment import deployable
from coupling.deployment_tables import DeployableRing
from coupling.generate_tables import RingTruss
from coupling.generation import Tables, made_by

Generated = RingTruss | DeployableRing
Generator = Annotated[Generated, Field(discriminator="kind")]
KINDS: list[str] = [
    kind
    for table in get_args(Generated)
    for kind in get_args(table.model_fields["kind"].annotation)
]
"""Every kind."""


def written_out(value: Any) -> Tables:
    """The tables that [generate.NAME] stands for; bad input is a pydantic ValidationError."""
    table: Generated = TypeAdapter(Generator).validate_python(value)
    return deployable(table) if isinstance(table, DeployableRing) else made_by(table)
