"""A beam with the section shape of the recipe, checked; argument: a folder to write to."""

import json
import sys
from pathlib import Path

from samples.case_samples import HEAD, SOLVER

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case

folder = Path(sys.argv[1])
BODY = """
[materials.steel]
kind = "isotropic"
E = 210e9
nu = 0.3
rho = 7850.0

[sections.tube]
shape = "square-tube"
side = 0.04
wall = 0.002

[bodies.arm]
kind = "beam"
length = 1.0
section = "tube"
material = "steel"
modes = [{ kind = "lowest", count = 2 }]
interfaces = { root = { at = "start" } }
"""


def spec(text):
    file = folder / "case.toml"
    file.write_text(HEAD + text + SOLVER.format(t_end=1.0, step=0.1, more=""))
    write_case(load_case(file), folder / "build")
    (body,) = (folder / "build/bodies").glob("*.json")
    return json.loads(body.read_text())["section"]


found = spec(BODY)
assert found["mesh"]["script"] == "box"
assert found["mesh"]["parameters"]["width"] == found["mesh"]["parameters"]["height"] == 0.04
assert set(found["regions"]) == {"top", "right", "bottom", "left"}
for old, new, words in [
    ("side = 0.04", "side = -0.04", "sections.tube.side = -0.04: value should be greater than 0"),
    ("side = 0.04", "sides = 0.04", "sections.tube.sides: unknown key; did you mean 'side'"),
    ("wall = 0.002", "wall = 0.02", "expected, with wall_bottom = 0.02, less than the height"),
]:
    message = ""
    try:
        spec(BODY.replace(old, new))
    except InputError as error:
        message = str(error)
    assert words in message, message
