"""The criterion of the recipe: by hand, in the search over a history, in reports of sections."""

import numpy as np

from plymotion.solver.package.common.materials import PlyStrength, YieldStrength
from plymotion.solver.strength import CRITERIA, criteria_of
from plymotion.solver.strength.search import Highest, PeakSearch

STEEL = YieldStrength(250e6)
assert [c.name for c in criteria_of(STEEL)] == ["von-mises", "tresca"]
assert "tresca" not in [c.name for c in criteria_of(PlyStrength(*[1e6] * 9))]
tresca = CRITERIA["tresca"]

# Tension, shear at half of the yield stress, and equal stresses in all directions.
stress = np.array([[250e6, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 125e6], [9e6, 9e6, 9e6, 0, 0, 0]])
np.testing.assert_allclose(tresca.assess(stress, STEEL).exposure, [1.0, 1.0, 0.0], atol=1e-15)

rng = np.random.default_rng(3)
unit, history = rng.normal(size=(40, 6, 6)), rng.normal(size=(6, 200)) * 1e6
everywhere = np.einsum("pij,jt->pti", unit, history)
found = Highest(np.zeros(1))
PeakSearch(unit, tresca, STEEL).peaks(
    history, np.zeros(200, dtype=int), found, Highest(np.zeros(1))
)
exposures = tresca.assess(everywhere, STEEL).exposure
np.testing.assert_allclose(found.exposure, exposures.max(), rtol=1e-12)
assert (found.point[0], found.column[0]) == np.unravel_index(exposures.argmax(), exposures.shape)
ratio = exposures / CRITERIA["von-mises"].assess(everywhere, STEEL).exposure
assert (ratio > 1.0 - 1e-12).all()
assert (ratio < 2.0 / np.sqrt(3.0) + 1e-12).all()
