"""The plate of the recipe, as an element and on a mesh."""

import sys
from pathlib import Path

import numpy as np
from samples.shell_element_samples import element_stiffness, isotropic

from plymotion.preprocess.shell.elements.pairs import Choice
from plymotion.preprocess.shell.shell_cells import cell_geometry as triangles

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "fe"))
from test_shell_elements_plate import deflection, series

points = np.array([[0.0, 0.0, 0.0], [2.0, 0.3, 0.0], [0.4, 1.1, 0.0]])
t = triangles(points, np.array([[0, 1, 2]]), np.array([1.0, 0.0, 0.0]))
laminate = isotropic(0.1)
K = element_stiffness(t, laminate, Choice(plate="centroid"))[0]
scale = np.abs(K).max()
np.testing.assert_allclose(K, K.T, atol=1e-12 * scale)
for i in range(3):
    shift, turn = np.zeros((3, 6)), np.zeros((3, 6))
    shift[:, i] = turn[:, 3 + i] = 1.0
    turn[:, :3] = np.cross(np.eye(3)[i], points)
    for rigid in (shift.ravel(), turn.ravel()):
        assert np.abs(K @ rigid).max() < 1e-12 * scale
# w = x: constant shear strain (1, 0), all of the energy.
u = np.zeros((3, 6))
u[:, 2] = points[:, 0]
area = 0.5 * (2.0 * 1.1 - 0.3 * 0.4)
np.testing.assert_allclose(u.ravel() @ K @ u.ravel(), area * laminate.Ds[0, 0], rtol=1e-12)
# A simply supported square: second order.
coarse, fine = (abs(deflection(n, 0.2, "centroid") / series(0.2) - 1.0) for n in (16, 32))
assert fine < 0.01
assert 3.5 < coarse / fine < 4.5
