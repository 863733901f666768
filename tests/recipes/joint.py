"""A ball on an inclined plane, by the joint of the recipe; argument: a folder to write to."""

import sys
from pathlib import Path

import numpy as np
from samples.case_samples import rigid, run_text

import plymotion
from plymotion.solver.errors import InputError

folder = Path(sys.argv[1])
assert plymotion.__file__.startswith(str(Path.cwd())), plymotion.__file__
text = (
    "gravity = [0.0, 0.0, -9.81]\n[ground.O]\nposition = [0.0, 0.0, 0.0]\n"
    + rigid("ball", 2.0, 0.1, {"a": (0, 0, 0)}, position=(1, 0, 0))
    + '[joints.floor]\nkind = "point_on_plane"\nbetween = ["ground.O", "ball.a"]\n'
    + "axis = [0.0, 1.0, 1.0]\n"
    + '[signals.y]\nkind = "position"\nat = "ball.a"\ncomponent = "y"\n'
    + '[signals.own]\nkind = "joint"\njoint = "floor"\ncoordinate = "x"\n'
    + '[signals.push]\nkind = "reaction"\njoint = "floor"\nquantity = "force"\n'
    + 'component = "magnitude"\n'
)
t, s, _ = run_text(folder, text, t_end=1.0, step=0.1)
# Down the plane of 45 degrees with g / sqrt(2); its y component is half of g.
np.testing.assert_allclose(s["y"], 0.5 * 0.5 * 9.81 * t**2, atol=1e-9)
np.testing.assert_allclose(s["push"], 2.0 * 9.81 / np.sqrt(2.0), rtol=1e-9)
assert s["own"][0] == 0.0
message = ""
try:
    run_text(folder, text.replace("axis =", "axes ="), t_end=1.0, step=0.1)
except InputError as error:
    message = str(error)
assert "joints.floor.axes: unknown key; did you mean 'axis'" in message, message
