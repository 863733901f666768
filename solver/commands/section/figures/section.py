"""Figures of a section: the mesh with the plies, and the stresses under unit resultants."""

import re
from pathlib import Path

from ....package.section.schema import SectionFile
from ....report.style import house_style
from .drawing import shape_of
from .mesh import draw_mesh
from .states import draw_states


def draw_section(section: SectionFile, folder: Path) -> list[Path]:
    """Write <name>-mesh.png and <name>-states.png into a folder; returns their paths.

    Raises InputError without matplotlib.
    """
    stem = re.sub(r"[^\w.+-]+", "-", section.name).strip("-.") or "section"
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    shape = shape_of(section.mesh)
    with house_style(formulas=True):
        return [
            draw_mesh(section, shape, folder / f"{stem}-mesh.png"),
            draw_states(section, shape, folder / f"{stem}-states.png"),
        ]
