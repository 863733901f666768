"""The text of a section description, and a way to change it."""

from pathlib import Path

BOX = """\
format = 1
title = "Box"
convention = "contour"

[mesh]
shape = "box"
width = 0.0242
height = 0.0136
wall = 0.000762

[materials.cfrp]
kind = "orthotropic"
E1 = 142e9
E2 = 9.8e9
E3 = 9.8e9
G12 = 6.0e9
G13 = 6.0e9
G23 = 4.8e9
nu12 = 0.42
nu13 = 0.42
nu23 = 0.42
rho = 1600.0

[laminates.skin]
material = "cfrp"
angles_deg = [0, 30]
ply_thickness = 0.000127
repeat = 3

[laminates.side]
plies = [
    { material = "cfrp", angle_deg = -15.0, thickness = 0.000127, repeat = 2 },
    { material = "cfrp", angle_deg = 15.0, thickness = 0.000127 },
]
symmetric = true

[regions.top]
laminate = "skin"

[regions.all]
laminate = "side"
"""


def replaced(file: Path, *changes: tuple[str, str]) -> Path:
    text = file.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    file.write_text(text)
    return file
