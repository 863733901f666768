"""A small picture of a section's plies for notebooks."""

import numpy as np

from ..solver.package.section.schema import CORNERS, SectionMeshData
from .html import Markup

MOST_CELLS = 6000  # of a picture that a notebook keeps
SIZE = 260  # pixels
# Okabe and Ito, as the figures of reports
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00")


def picture(mesh: SectionMeshData) -> Markup:
    """Return the cells of a section as SVG, coloured by ply; nothing for a very fine mesh."""
    cells = len(mesh.cell_types)
    if cells > MOST_CELLS:
        return Markup("")
    nodes = mesh.nodes
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    scale = (SIZE - 8) / float(np.max(high - low) or 1.0)
    x = 4 + (nodes[:, 0] - low[0]) * scale
    y = 4 + (high[1] - nodes[:, 1]) * scale
    paths: dict[int, list[str]] = {}
    for c in range(cells):
        first = int(mesh.offsets[c])
        corners = mesh.connectivity[first : first + CORNERS[int(mesh.cell_types[c])]]
        points = "L".join(f"{x[i]:.1f} {y[i]:.1f}" for i in corners)
        paths.setdefault(int(mesh.ply[c]), []).append(f"M{points}Z")
    parts = [
        f'<path d="{"".join(found)}" fill="{COLOURS[ply % len(COLOURS)]}" stroke="white" '
        'stroke-width="0.2"/>'
        for ply, found in sorted(paths.items())
    ]
    height = 8 + float(high[1] - low[1]) * scale
    return Markup(f'<svg width="{SIZE}" height="{height:.0f}">{"".join(parts)}</svg>')
