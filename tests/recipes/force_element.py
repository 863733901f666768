"""A ball on the cubic spring of the recipe; argument: a folder to write to."""

import sys
from pathlib import Path

import numpy as np
from samples.case_samples import rigid, run_text
from scipy.special import gamma

from plymotion.solver.dynamics.elements.forces.contract import FORCE, N_ELEMENT_ROW, STIFFNESS
from plymotion.solver.dynamics.elements.forces.table import ELEMENTS, KINDS, MOST_ROWS, element_rows
from plymotion.solver.errors import InputError
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.integrators.radau import Radau
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import ForceTable, MarkerTable, rigid_body

folder = Path(sys.argv[1])
text = (
    "[ground.O]\nposition = [0.0, 0.0, 0.0]\n"
    + rigid("ball", 2.0, 0.1, {"a": (0, 0, 0)}, position=(1, 0, 0))
    + '[joints.rail]\nkind = "prismatic"\nbetween = ["ground.O", "ball.a"]\n'
    + "axis = [1.0, 0.0, 0.0]\n"
    + '[forces.pull]\nkind = "cubic_spring"\nbetween = ["ground.O", "ball.a"]\n'
    + "strength = 50.0\n"
    + '[signals.x]\nkind = "position"\nat = "ball.a"\ncomponent = "x"\n'
)
# 2 x'' = -50 x^3 from rest at 1 m: at the origin after K(1/2) / sqrt(k/m), by energy.
k, m = 50.0, 2.0
quarter = gamma(0.25) ** 2 / (4.0 * np.sqrt(np.pi)) / np.sqrt(k / m)
t, s, summary = run_text(folder, text, t_end=quarter, step=quarter / 4)
np.testing.assert_allclose(s["x"][-1], 0.0, atol=1e-7)
assert summary["checks"]["energy_drift_relative"] < 1e-7, summary

# The row of Newton's matrix: force and stiffness at 2 m.
one, two = np.zeros(24), np.zeros(24)
one[3:12] = two[3:12] = np.eye(3).ravel()
two[2] = 2.0
rows = np.zeros((MOST_ROWS, N_ELEMENT_ROW))
element_rows(KINDS["cubic_spring"], one, two, np.array([k]), rows)
assert (rows[0, FORCE], rows[0, STIFFNESS]) == (k * 8.0, 3.0 * k * 4.0)
assert ELEMENTS["cubic_spring"].parameters == ("strength",)

# A stiff one in Newton's matrix of radau: 14 swings; plain NumPy takes 5 ms a step.
body = rigid_body("ball", 1.0, np.zeros(3), np.eye(3))
markers = [MarkerTable(-1, np.zeros(3)), MarkerTable(0, np.zeros(3))]
model = assemble_model([body], markers, [], forces=[ForceTable("s", "cubic_spring", 0, 1, (1e8,))])
assert model.layout.newton.place.size == 1
y0 = np.zeros(14)
y0[0], y0[3], y0[8] = 1.0, 1.0, 0.5
made = Radau(model, 0.0, y0, 0.005, rtol=1e-6, atol=np.full(14, 0.1))
done = integrate(made, [0.0, 0.005])
assert done.status == "finished", done.message

for old, new, words in [
    ("strength = 50.0", "strength = -1.0", "forces.pull.strength = -1.0: value should be greater"),
    ("strength = 50.0", "", "forces.pull.strength: missing"),
    ("strength", "strenght", "forces.pull.strenght: unknown key; did you mean 'strength'"),
    ("cubic_spring", "cubic_sprin", "did you mean 'cubic_spring'"),
]:
    message = ""
    try:
        run_text(folder, text.replace(old, new), t_end=0.1, step=0.1)
    except InputError as error:
        message = str(error)
    assert words in message, message
