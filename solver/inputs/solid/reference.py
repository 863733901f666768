"""The manual of solid descriptions, generated from the models.

python -m plymotion.solver.inputs.solid.reference > docs/solid-description.md
"""

from ..common.material import MATERIAL_TABLES
from ..common.page import chapters
from .description import SOLID_TABLES

HEAD = """\
# The solid description

A part from CAD, or a mesh of tetrahedra or hexahedra, is one TOML file. It is checked before the
analysis. Unknown keys, names that do not exist and values out of bounds are errors. A message names
file, key, value and expectation. `plymotion new bracket` writes an example. `make docs` generates
this page from solver/inputs/solid/. [solids.md](solids.md) explains meshes, results and accuracy.

    plymotion solid bracket.toml

Units are SI, also of positions: a STEP file in millimetres has its bores at `point = [0.015, ...]`.

```toml
format = 1
supports = ["root"]            # of load cases and of frequencies of the held part

[mesh]
file = "bracket.step"
size = 0.005

[materials.aluminium]
kind = "isotropic"
E = 70e9
nu = 0.33
rho = 2700.0

[regions.all]
material = "aluminium"

[interfaces.root]
bore = { radius = 0.008, point = [0.015, 0.020, 0.005], direction = [0, 0, 1] }

[interfaces.top]
plane = { point = [0, 0, 0.010], normal = [0, 0, 1] }
link = "average"

[loads.press.top]
at = "top"
force = [0, 0, -500.0]
```
"""


def solid_page() -> str:
    """Return docs/solid-description.md."""
    page = "\n".join([HEAD, *chapters((*SOLID_TABLES, *MATERIAL_TABLES))])
    return page.rstrip("\n") + "\n"


if __name__ == "__main__":
    print(solid_page(), end="")
