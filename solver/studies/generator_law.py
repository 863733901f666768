"""The law of the generator of a turbine, by the torque of its blades under load."""

import re
import tomllib
from pathlib import Path

import numpy as np

from ..dynamics.analysis.recovery import Recording
from ..inputs.case.load import load_case
from ..mechanism.build import build
from ..mechanism.start import starting_state
from ..package.common.files import write_text
from ..signals.rotor import rotor_values
from .cases import build_folder
from .modes.state import spec_of_run


def take_bent_blades(file: Path) -> None:
    """Put the torque of bent blades into the law of the generator of a case of a turbine.

    At the start of its run `steady`, with the shapes that belong to the loads. Rigid blades give
    several per cent more, with which a rotor turns too slowly.

    Raises
    ------
    InputError
        The blades have no such shapes; the file stays.
    """
    case, text = load_case(file), file.read_text(encoding="utf-8")
    spec = spec_of_run(case, "steady", build_folder(file), None)
    built = build(spec.mechanism, spec.packages)
    names = built.joint_names, built.body_names
    y = starting_state(built.model, built.start, "quasi-static", *names)
    (torque,) = rotor_values(built, "moment")(Recording(built.model, np.zeros(1), y[None]))
    speed = tomllib.loads(text)["parameters"]["speed"]
    write_text(file, re.sub(r"(?m)^best = \S+", f"best = {torque / speed**2:.6g}", text, count=1))
