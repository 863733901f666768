"""An accelerometer on a hinged arm that turns at a constant speed; argument: a folder."""

import sys
from pathlib import Path

import numpy as np
from samples.case_samples import rigid, run_text

from plymotion.solver.errors import InputError

folder, g, w, r = Path(sys.argv[1]), 9.81, 3.0, 0.4
signal = '[signals.{0}]\nkind = "specific_force"\nat = "arm.tip"\ncomponent = "{0}"\n'
text = (
    f"gravity = [0.0, {-g}, 0.0]\n[ground.O]\nposition = [0.0, 0.0, 0.0]\n"
    + rigid("arm", 2.0, 0.1, {"a": (0, 0, 0), "tip": (r, 0, 0)})
    + '[joints.hinge]\nkind = "revolute"\nbetween = ["ground.O", "arm.a"]\naxis = [0, 0, 1.0]\n'
    + f"drive = {{ speed = {w} }}\n"
    + signal.format("x")
    + signal.format("y")
)
t, s, _ = run_text(folder, text, t_end=1.0, step=0.05)
# In the axes of the arm: centripetal along it, and gravity that turns against it.
np.testing.assert_allclose(s["x"], -(w**2) * r + g * np.sin(w * t), atol=1e-6)
np.testing.assert_allclose(s["y"], g * np.cos(w * t), atol=1e-6)
message = ""
try:
    run_text(folder, text.replace('"specific_force"', '"specific_forces"', 1), t_end=1.0, step=0.1)
except InputError as error:
    message = str(error)
assert "specific_force" in message, message
