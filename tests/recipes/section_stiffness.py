"""The section shape of the recipe, meshed and solved: that of a box, and closed forms."""

import numpy as np

from plymotion.preprocess.section.section_analysis import analyse
from plymotion.solver.inputs.section.shapes.library import expand, walls

STEEL = {"kind": "isotropic", "E": 210e9, "nu": 0.0, "rho": 7850.0}
PLIES = [{"material": "steel", "angle_deg": 0.0}]


def stiffness(shape, **sizes):
    of_shape = walls(shape, sizes)
    spec = {
        "name": shape,
        "convention": "contour",
        "mesh": expand(shape, {**sizes, "wall": 0.002}),
        "materials": {"steel": STEEL},
        "regions": {
            wall.region: {
                "plies": [{"material": "steel", "angle_deg": 0.0}],
                "direction": wall.direction,
            }
            for wall in of_shape
        },
    }
    return np.array(analyse(spec, estimate=False).K)


tube = stiffness("square-tube", side=0.04)
np.testing.assert_allclose(tube, stiffness("box", width=0.04, height=0.04), rtol=1e-12)
area, second = 0.04**2 - 0.036**2, (0.04**4 - 0.036**4) / 12.0
np.testing.assert_allclose(tube[0, 0], 210e9 * area, rtol=1e-9)
np.testing.assert_allclose(tube[4, 4], 210e9 * second, rtol=1e-9)
