"""A rib that is stiff in the plane of its plate keeps shear strain from the cells beside it."""

from typing import Any

import numpy as np
import pytest
from samples.shell_specs import METAL, plate

from plymotion.preprocess.shell.analyses.analysis import analyse

SIDE, OFFSET = 0.06, 0.06
E = METAL["E"]
DIAGONAL = [E * SIDE**2, E * SIDE**2 / 3, E * SIDE**2 / 3, *[E * SIDE**4 / 12] * 3]


def energy(n: int, in_plane: float, membrane: str = "opt") -> tuple[float, set[str]]:
    """Strain energy of a cantilever with a rib along its free edge, and the warnings."""
    factors = np.array([1.0, in_plane, 1.0, 1.0, 1.0, in_plane])
    mass = np.diag([1.0, 1.0, 1.0, 1e-3, 5e-4, 5e-4]).tolist()
    rib = {"at": "top", "offset": [0.0, OFFSET], "mass": mass}
    rib["stiffness"] = np.diag(DIAGONAL * factors).tolist()
    tables: dict[str, Any] = {
        "supports": {"left": {"at": "left", "fixed": "all"}},
        "links": {"end": {"at": "right", "kind": "rigid"}},
        "loads": {"F": {"tip": {"at": "end", "force": [0.0, 0.3, 1.0]}}},
        "stiffeners": {"rib": rib},
        "elements": {"membrane": membrane},
    }
    found = analyse(plate(n, 0.01, **tables))
    return float(found.cases.energy[0]), {w["code"] for w in found.warnings}


@pytest.mark.provokes("stiffener-locks-cells")
def test_stiff_rib_locks_and_the_advice_clears_it() -> None:
    stiff, codes = energy(8, 1.0)
    right, advised = energy(8, 1.0, "cst")
    assert stiff < 0.9 * right
    assert "stiffener-locks-cells" in codes
    assert right == pytest.approx(energy(24, 1.0, "cst")[0], rel=0.02)
    assert "stiffener-locks-cells" not in advised


def test_rib_that_is_soft_in_the_plane_does_not() -> None:
    soft, codes = energy(8, 1e-3)
    assert "stiffener-locks-cells" not in codes
    assert soft == pytest.approx(energy(24, 1e-3)[0], rel=0.03)
