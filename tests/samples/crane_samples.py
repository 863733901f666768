"""Cranes: a heavy load on a chain of light links below a driven trolley."""

from pathlib import Path
from typing import Any

import numpy as np
from samples.case_samples import HEAD, rigid

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run.execution import read_run
from plymotion.solver.run.inputs import RunSpec

G, LOAD = 9.81, 2000.0
E, NU, DENSITY, WIRE = 2e11, 0.3, 7850.0, 0.012  # steel, diameter of a link [m]


def crane_text(
    links: int,
    mass: float = 0.05,
    length: float = 1.0,
    *,
    load: float = LOAD,
    drive: str = "",
    joint: str = "revolute",
    point: bool = True,
    more: str = "",
) -> str:
    """Rigid links hang down from a trolley on a rail along x; signals x and z of the load.

    The load is a point mass at the last link, or a body on a ball joint.
    """
    text = f"""
gravity = [0.0, 0.0, -{G}]
[ground.rail]
position = [0.0, 0.0, 0.0]
[joints.rail]
kind = "prismatic"
between = ["ground.rail", "trolley.hook"]
axis = [1.0, 0.0, 0.0]
{drive}
"""
    end = f"link{links - 1}.low"
    for c in "xz":
        text += f'[signals.{c}]\nkind = "position"\nat = "{end}"\ncomponent = "{c}"\n'
    text += rigid("trolley", 50.0, 1.0, {"hook": (0, 0, 0)})
    above, across = "trolley.hook", mass * length**2 / 12.0
    axis = "axis = [0.0, 1.0, 0.0]\n" if joint == "revolute" else ""
    for i in range(links):
        ends = {"high": (0, 0, 0), "low": (0, 0, -length)}
        inertia = [across, across, 2e-3 * across]
        at, centre = (0, 0, -i * length), (0, 0, -length / 2)
        text += rigid(f"link{i}", mass, inertia, ends, centre=centre, position=at)
        text += f'[joints.pin{i}]\nkind = "{joint}"\nbetween = ["{above}", "link{i}.high"]\n{axis}'
        above = f"link{i}.low"
    if point:
        return text + f'[masses.load]\nmass = {load}\nat = "{end}"\n{more}'
    below = (0, 0, -links * length - 0.5)
    text += rigid("load", load, 0.1 * load, {"top": (0, 0, 0.5)}, position=below)
    return text + f'[joints.hook]\nkind = "spherical"\nbetween = ["{end}", "load.top"]\n{more}'


def rigid_crane(folder: Path, links: int, **keys: Any) -> RunSpec:
    """A run of `crane_text`."""
    file = folder / "case.toml"
    solver = "[solver]\nt_end = 1.0\noutput_step = 0.1\n[runs.base]\n"
    file.write_text(HEAD + crane_text(links, **keys) + solver)
    write_case(load_case(file), folder / "build", None)
    return read_run(folder / "build/runs/base.json")


def beam_crane(
    links: int, t_end: float = 1.0, drive: dict[str, Any] | None = None
) -> tuple[dict[str, Any], tuple[np.ndarray, np.ndarray]]:
    """Steel wires of 1 m as links, with geometric stiffening, down along x; matrices of a wire.

    The rail is along y.
    """
    area, second = np.pi * WIRE**2 / 4.0, np.pi * WIRE**4 / 64.0
    shear = E / (2.0 * (1.0 + NU))
    K = np.diag([E * area, *[0.9 * shear * area] * 2, 2.0 * shear * second, *[E * second] * 2])
    M = DENSITY * np.diag([area, area, area, 2.0 * second, second, second])
    trolley = {"kind": "rigid", "mass": 50.0, "inertia": np.eye(3).tolist()}
    rail = {"kind": "prismatic", "between": ["ground.rail", "trolley.hook"], "axis": [0, 1.0, 0]}
    table: dict[str, Any] = {
        "gravity": [G, 0.0, 0.0],
        "ground": {"rail": {"position": [0.0, 0.0, 0.0]}},
        "bodies": {"trolley": trolley | {"interfaces": {"hook": {"position": [0.0, 0.0, 0.0]}}}},
        "joints": {"rail": rail | ({"drive": drive} if drive else {})},
        "masses": {"load": {"mass": LOAD, "at": f"link{links - 1}.tip"}},
        "signals": {
            c: {"kind": "position", "at": f"link{links - 1}.tip", "component": c} for c in "xy"
        },
        "solver": {
            "t_end": t_end,
            "output_step": 0.05,
            "geometric_stiffening": True,
            "integrator": "radau",
        },
    }
    above = "trolley.hook"
    for i in range(links):
        table["bodies"][f"link{i}"] = {
            "kind": "beam",
            "length": 1.0,
            "section": "s",
            "material": "m",
            "elements": 8,
            "modes": [{"kind": "bending-xy", "count": 8}],
            "position": [float(i), 0.0, 0.0],
            "interfaces": {"root": {"at": "start"}, "tip": {"at": "end"}},
        }
        pin = {"kind": "revolute", "between": [above, f"link{i}.root"], "axis": [0.0, 0.0, 1.0]}
        table["joints"][f"pin{i}"] = pin
        above = f"link{i}.tip"
    return table, (K, M)
