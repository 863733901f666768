"""Scenes whose derivatives are compared with six-point differences of runs at rtol = 1e-10."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from samples.case_samples import HEAD, rigid
from samples.coordinate_samples import carriage, force, wheel

from plymotion.solver.dynamics.analysis.recovery import DIFFERENCE, Recording
from plymotion.solver.inputs.common.text_file import read_toml
from plymotion.solver.package import read_package, write_package
from plymotion.solver.package.common.design import Derivative
from plymotion.solver.run.execution import read_run
from plymotion.solver.run.inputs import RunSpec
from plymotion.solver.run.preparation import integrated, prepare
from plymotion.solver.studies.modes.state import spec_of_run
from plymotion.solver.studies.sensitivities.differentiated_run import with_sensitivities
from plymotion.solver.studies.sensitivities.parameters import (
    Parameter,
    parameter_of,
    with_parameters,
)


class Scene(NamedTuple):
    """A case of rigid bodies as text, the numbers of interest, and the step of differences."""

    text: str
    keys: tuple[str, ...]
    t_end: float = 1.0
    solver: str = ""
    head: str = ""
    relative: float = 2e-3


def position(name: str, at: str, component: str, kind: str = "position") -> str:
    return f'[signals.{name}]\nkind = "{kind}"\nat = "{at}"\ncomponent = "{component}"\n'


DOWN = "gravity = [0.0, 0.0, -9.81]\n"
ROD = (
    rigid("rod", 2.0, (0.01, 0.7, 0.7), {"a": (0, 0, 0), "tip": (1, 0, 0)}, centre=(0.5, 0, 0))
    + "[ground.O]\nposition = [0.0, 0.0, 0.0]\n[ground.P]\nposition = [0.5, 0.0, 1.0]\n"
    + '[joints.hinge]\nkind = "revolute"\nbetween = ["ground.O", "rod.a"]\naxis = [0.0, 1.0, 0.0]\n'
)
SIGNALS = (
    position("x", "rod.tip", "x")
    + position("a", "rod.tip", "z", "acceleration")
    + '[signals.R]\nkind = "reaction"\njoint = "hinge"\nquantity = "force"\ncomponent = "x"\n'
    + '[signals.angle]\nkind = "joint"\njoint = "hinge"\n'
)
SPRING = (
    '[forces.spring]\nkind = "spring"\nbetween = ["ground.P", "rod.tip"]\nstiffness = 30.0\n'
    "damping = 0.5\nlength = 0.8\n"
)
SECOND = (
    rigid(
        "two", 1.0, (0.01, 0.3, 0.3), {"a": (0, 0, 0), "tip": (0.8, 0, 0)},
        centre=(0.4, 0, 0), position=(1.0, 0, 0),
    )
    + '[joints.elbow]\nkind = "KIND"\nbetween = ["rod.tip", "two.a"]\naxis = [0.0, 1.0, 0.0]\n'
    + position("tip", "two.tip", "z")
)  # fmt: skip
PID = {"joint": "rail", "coordinate": "z", "proportional": 40.0, "integral": 30.0,
       "derivative": 4.0, "setpoint": "0.3 * sin(3 * t) + 0.1"}  # fmt: skip
GAINS = ("forces.c.proportional", "forces.c.integral", "forces.c.derivative", "bodies.car.mass")
STOP = {"joint": "rail", "coordinate": "z", "upper": 0.5, "stiffness": 1e4, "exponent": 1.0}
PUSH = '[forces.push]\nkind = "force"\nat = "rod.tip"\ndirection = [0.0, 0.0, 1.0]\n'

SCENES = {
    "spring pendulum": Scene(
        ROD + SPRING + SIGNALS,
        ("forces.spring.stiffness", "forces.spring.damping", "forces.spring.length",
         "bodies.rod.mass", "gravity.2", "bodies.rod.centre.0", "ground.P.position.0",
         "ground.O.position.0"), 2.0, head=DOWN,
    ),
    "double pendulum": Scene(
        ROD + SECOND.replace("KIND", "revolute") + SIGNALS,
        ("bodies.rod.mass", "bodies.two.mass", "gravity.2", "bodies.two.inertia.1.1"), head=DOWN,
    ),
    "spatial double pendulum": Scene(
        ROD + SECOND.replace("KIND", "spherical").replace('axis = [0.0, 1.0, 0.0]\n[sig', "[sig")
        + SIGNALS,
        ("bodies.two.mass", "bodies.two.inertia.1.1", "gravity.1"),
        head="gravity = [0.3, 0.4, -9.81]\n",
    ),
    "start speed": Scene(
        wheel(force("b", "friction", joint="axle", coulomb=0.4, rest_velocity=0.3, viscous=0.1),
              spin=3.0),
        ("bodies.wheel.angular_velocity.2", "forces.b.coulomb", "forces.b.rest_velocity"),
    ),
    "equilibrium start": Scene(
        ROD + SPRING + SIGNALS + PUSH + 'law = { polynomial = [0.0, 3.0] }\n',
        ("forces.spring.stiffness", "forces.spring.length", "gravity.2"),
        solver='start = "equilibrium"\n', head=DOWN,
    ),
    "pid": Scene(carriage(force("c", "controller", **PID), mass=1.3), GAINS, 2.0),
    "sampled pid": Scene(
        carriage(force("c", "controller", sample_time=0.05, **PID), mass=1.3), GAINS, 2.0
    ),
    "filtered pid": Scene(
        carriage(force("c", "controller", filter_time=0.02, **PID), mass=1.3), GAINS, 2.0
    ),
    "table": Scene(
        ROD + SPRING + SIGNALS + PUSH
        + 'law = { table = { times = [0.0, 0.3, 0.5, 2.0], values = [0.0, 8.0, -5.0, 2.0], '
        'interpolation = "linear" } }\n',
        ("forces.spring.stiffness", "bodies.rod.mass"), head=DOWN,
    ),
    "expression": Scene(
        ROD + SPRING + SIGNALS + PUSH + 'law = { expression = "6 * sin(7 * t) * exp(-t)" }\n',
        ("forces.spring.damping", "gravity.2"), head=DOWN,
    ),
    "drive": Scene(
        ROD.replace('"rod.a"]\n', '"rod.a"]\ndrive = { polynomial = [0.0, 0.4, 1.5] }\n')
        + SECOND.replace("KIND", "revolute") + SIGNALS,
        ("bodies.two.mass", "gravity.2", "joints.hinge.drive.polynomial.1"), head=DOWN,
    ),
    "jump": Scene(
        ROD + SPRING + SIGNALS + PUSH + 'law = { expression = "8 * (t < 0.31)" }\n',
        ("forces.spring.stiffness", "bodies.rod.mass"),
        head=DOWN,
    ),
    "steady spin": Scene(
        ROD.replace("axis = [0.0, 1.0, 0.0]", "axis = [0.0, 0.0, 1.0]")
        + SECOND.replace("KIND", "revolute")
        + SIGNALS,
        ("bodies.two.mass",),
        head=DOWN,
        solver='start = "equilibrium"\nspin = { speed = 6.0, axis = [0.0, 0.0, 1.0] }\n',
    ),
    "redundant": Scene(
        ROD
        + '[joints.again]\nkind = "revolute"\nbetween = ["ground.O", "rod.a"]\n'
        + "axis = [0.0, 1.0, 0.0]\n"
        + SPRING
        + position("x", "rod.tip", "x"),
        ("forces.spring.stiffness", "bodies.rod.mass"),
        head=DOWN,
    ),
    "elastic stop": Scene(
        carriage(force("stop", "limit_stop", **STOP), speed=1.0),
        ("forces.stop.stiffness", "bodies.car.mass"), relative=1e-3,
    ),
}  # fmt: skip


def specification(scene: Scene, folder: Path, rtol: float) -> tuple[RunSpec, list[Parameter]]:
    """Write a scene as a case; return its run and its parameters."""
    file = folder / "case.toml"
    solver = f"[solver]\nt_end = {scene.t_end}\noutput_step = {scene.t_end / 50}\n"
    solver += f'integrator = "radau"\nrtol = {rtol}\n{scene.solver}[runs.base]\n'
    file.write_text(HEAD + scene.head + scene.text + solver)
    table = read_toml(file, "case file")
    case, members = with_parameters(table, file, "base", scene.keys)
    spec = spec_of_run(case, "base", folder / "build", None)
    return spec, [parameter_of(spec, *member) for member in members]


def with_modulus(file: Path, body: str, folder: Path, **solver: object) -> RunSpec:
    """Return a run whose package of a body has the derivative by Young's modulus over its value.

    K' = K is exact for an isotropic body: the package is written and read again.
    """
    spec = read_run(file).changed({f"solver.{key}": value for key, value in solver.items()})
    package = spec.packages[body]
    rate = Derivative("E", "number", (), {"modes/stiffness": package.stiffness})
    write_package(folder / "modulus.vtkhdf", replace(package, design=(rate,)))
    packages = {**spec.packages, body: read_package(folder / "modulus.vtkhdf")}
    return replace(spec, packages=packages)


def scaled(spec: RunSpec, body: str, factor: float) -> RunSpec:
    """Return the run with another Young's modulus."""
    package = spec.packages[body]
    changed = replace(package, stiffness=factor * package.stiffness)
    return replace(spec, packages={**spec.packages, body: changed})


def signals_of(spec: RunSpec) -> dict[str, np.ndarray]:
    spec = spec.changed({"solver.rtol": 1e-10})
    prepared = prepare(spec.mechanism, spec.packages)
    solution = integrated(prepared).solution
    recording = Recording(prepared.model, solution.t, np.asarray(solution.y[:]))
    return {name: sensor.values(recording) for name, sensor in prepared.measured.items()}


def differences(at, h: float) -> dict[str, np.ndarray]:
    """Derivatives of the signals of at(change of the parameter), by six points."""
    found: dict[str, np.ndarray] = {}
    for place, weight in DIFFERENCE:
        for name, values in signals_of(at(place * h)).items():
            found[name] = found.get(name, 0.0) + weight * values / h
    return found


def errors(scene: Scene, folder: Path, rtol: float, keys=None) -> dict[tuple[str, str], float]:
    """Largest errors over the largest derivative of a signal, by parameter and signal."""
    spec, parameters = specification(scene, folder, rtol)
    result, _ = with_sensitivities(spec, parameters)
    found = {}
    for parameter in parameters:
        if keys is not None and parameter.name not in keys:
            continue
        h = scene.relative * (abs(parameter.value) or 1.0)
        expected = differences(lambda x, p=parameter: spec.changed({p.name: p.value + x}), h)
        for one in result.sensitivities:
            if one.parameter == parameter.name:
                values = expected[one.signal]
                scale = np.abs(values).max()
                if scale > 1e-9:
                    found[parameter.name, one.signal] = np.abs(one.values - values).max() / scale
    return found
