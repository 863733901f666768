"""Keys of cross-sections in a case file."""

from typing import TYPE_CHECKING, Any

from pydantic import model_validator

from ...common.table import FilePath, Table, entry, optional
from ...section.mesh_table import ShapeMesh, shape_or

CHANGES = "other values at dotted keys of the description, in quotes: " + (
    '{ "laminates.wall.angles_deg.1" = 30 }'
)


class DescribedSection(Table):
    """`[sections.NAME]` with `file` or `description`: a section with lay-ups, or its own mesh.

    Keys of a description: docs/section-description.md.
    """

    file: FilePath | None = optional("path of a section description, relative to the case file")
    description: dict[str, Any] | None = optional(
        "instead: the description itself, without format and title; it may use the materials of "
        "the case"
    )
    changes: dict[str, Any] = entry(CHANGES, default={})

    @model_validator(mode="after")
    def _one_of_two(self) -> "DescribedSection":
        if (self.file is None) == (self.description is None):
            raise ValueError("expected either `file` or `description`")
        return self


if TYPE_CHECKING:
    Section = ShapeMesh | DescribedSection
else:
    Section = shape_or(DescribedSection)
