"""Robots in other programs, for robots.py: FMI by fmpy, chains in MuJoCo, contact in closed form.

The arm of cases/robot-import with two laminated tubes and motors as inputs; the programs are those
of `make exchange-programs`.
"""

import importlib
import os
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import pyplot
from scipy.linalg import eigh

import plymotion as pm
from plymotion.preprocess.exchange.formats.mujoco import write as write_chain
from plymotion.solver.package import read_package

ROOT = Path(__file__).resolve().parents[1]
READY = ROOT / "tests/packages/robot-import"
TORQUES = np.array([20.0, 20.0, 10.0, 0.2, 0.2, 0.02])  # of the joints, from the base on [N m]
H = 1e-3  # communication step [s]


def driven_arm(**solver: Any) -> pm.Case:
    """The arm with a motor in each joint in place of the drives, without signals of links."""
    case = pm.load(ROOT / "cases/robot-import/case.toml")
    for name, joint in case.table["joints"].items():
        del joint["drive"]
        places, axis = joint["between"], joint["axis"]
        case.rotary_spring(f"{name}_motor", *places, axis=axis, actuator={"constant": 0.0})
    tip = {"kind": "position", "at": "flange.tool"}
    case.table["signals"] = {f"tip_{axis}": {**tip, "component": axis} for axis in "xyz"}
    case.table["figures"], case.table["variants"]["tubes"]["signals"] = {}, {}
    case.table["solver"] |= {"start": "positions", **solver}
    return case


def fmi(folder: Path) -> dict[str, Any]:
    """Return findings, whether a state gives equal bits, and the error of derivatives."""
    fmpy = importlib.import_module("fmpy")
    fmi3 = importlib.import_module("fmpy.fmi3")
    check = importlib.import_module("fmpy.validation").validate_fmu
    case, found, here = driven_arm(rtol=1e-8), dict[str, Any](), Path.cwd()
    os.chdir(folder)
    try:
        for to in ("fmu", "fmu3"):
            file = folder / f"{to}.fmu"
            pm.export(case, to, file, run="tubes", packages=READY)
            found[f"findings of fmpy, {to}"] = check(str(file))
    finally:
        os.chdir(here)
    known = fmpy.read_model_description(str(file))
    place = {v.name: v.valueReference for v in known.modelVariables}
    inputs = [place[name] for name in place if name.startswith("forces.")]
    outputs = [place[name] for name in place if name.startswith("signals.")]
    unit = fmi3.FMU3Slave(
        guid=known.guid,
        unzipDirectory=fmpy.extract(str(file), unzipdir=str(folder / "unit")),
        modelIdentifier=known.coSimulation.modelIdentifier,
        instanceName="arm",
    )
    unit.instantiate()
    unit.enterInitializationMode(startTime=0.0)
    unit.exitInitializationMode()

    def step(k: int, more: np.ndarray | float = 0.0) -> np.ndarray:
        unit.setFloat64(inputs, list(TORQUES * np.sin(0.01 * k + np.arange(6)) + more))
        unit.doStep(k * H, H)
        return np.array(unit.getFloat64(outputs))

    for k in range(10):
        step(k)
    state = unit.getFMUState()
    paths = []
    for _ in range(2):
        paths.append([step(k) for k in range(10, 30)])
        unit.setFMUState(state)
    found["rollback: bits are equal"] = bool(np.array_equal(*paths))
    step(10)
    worst, seeds = 0.0, np.eye(6) * TORQUES
    tangents = [np.array(unit.getDirectionalDerivative(outputs, inputs, list(s))) for s in seeds]
    for seed, tangent in zip(seeds, tangents, strict=True):
        gaps = []
        for size in (1.0, 3.0):  # the last torque moves the tool by little over its rounding
            ends = []
            for share in (0.5, -0.5, 1.0, -1.0):
                unit.setFMUState(state)
                ends.append(step(10, size * share * seed))
            gap = tangent - (8.0 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / (6.0 * size)
            gaps.append(float(np.abs(gap).max() / np.abs(tangent).max()))
        worst = max(worst, min(gaps))
    found["derivatives against differences, relative"] = worst
    unit.terminate()
    unit.freeInstance()
    return found


def orders(folder: Path, picture: Path) -> dict[str, float]:
    """Return the largest distance of the tip from that of our run by `drive_order`; draw it.

    The arm of cases/exchange in fmpy, steps of 1 ms; our run follows the law of the drive itself.
    """
    fmpy = importlib.import_module("fmpy")
    case, run = pm.load(ROOT / "cases/exchange/case.toml"), "calculix-solid"
    ready, file = ROOT / "tests/packages/exchange", folder / "arm.fmu"
    case.solver.output_step = H
    pm.export(case, "fmu3", file, run=run, packages=ready)
    own = pm.run(case, run, packages=ready, out=folder / "own").signals
    t = own["tip_x"].t
    s = np.minimum(t / 0.4, 1.0)
    angle = -(10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5)
    rows = np.array(
        list(zip(t, angle, strict=True)), [("time", float), ("joints.hinge.drive", float)]
    )
    found, axes = {}, pyplot.figure(figsize=(8.0, 3.6), layout="constrained").gca()
    for order, line in enumerate((":", "--", "-")):
        unit = fmpy.simulate_fmu(
            str(file),
            stop_time=t[-1],
            output_interval=H,
            input=rows,
            start_values={"drive_order": order},
        )
        gaps = [
            pm.Signal(key, "m", "", t, unit[f"signals.{key}"]) - own[key]
            for key in ("tip_x", "tip_y", "tip_z")
        ]
        gap = pm.norm(*gaps)
        gap.description = "tip, distance from our run"
        gap.plot(axes, label=f"drive_order = {order}", linestyle=line)
        found[f"drive_order {order}"] = gap.max
    axes.set(yscale="log", ylim=(1e-9, 1e-2), xlim=(0.0, t[-1]))
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    axes.figure.savefig(picture, dpi=140)
    return found


def mujoco(folder: Path) -> dict[str, float]:
    """Return the largest relative error of the three lowest frequencies of each tube."""
    engine, found = importlib.import_module("mujoco"), {}
    for file in sorted(READY.glob("*.vtkhdf")):
        package, out = read_package(file), folder / "chain.xml"
        write_chain(package, out, file)
        model = engine.MjModel.from_xml_path(str(out))
        data = engine.MjData(model)
        engine.mj_forward(model, data)
        M = np.zeros((model.nv, model.nv))
        engine.mj_fullM(model, data, M)
        w = np.sqrt(eigh(np.diag(model.jnt_stiffness.ravel()), M, eigvals_only=True))[:3]
        own = np.sqrt(eigh(package.stiffness, package.mass, eigvals_only=True))[:3]
        found[file.stem] = float(np.abs(w / own - 1.0).max())
    return found


def contact(folder: Path) -> dict[str, float]:
    """Return relative errors of a ball that falls: instant of the impact, speed after it."""
    radius, height, e = 0.1, 0.3, 0.8
    case = pm.Case("ball", gravity=[0.0, 0.0, -9.81])
    case.rigid("ball", mass=1.0, inertia=(0.004 * np.eye(3)).tolist(), position=[0, 0, height])
    case.table["bodies"]["ball"]["interfaces"] = {"c": {"position": [0.0, 0.0, 0.0]}}
    case.table["ground"] = {"floor": {"position": [0.0, 0.0, 0.0]}}
    how = {"radius": radius, "stiffness": 1e10, "restitution": e}
    case.table["forces"] = {
        "floor": {"kind": "contact", "between": ["ground.floor", "ball.c"], **how}
    }
    place = {"at": "ball.c", "component": "z"}
    case.table["signals"] = {"v": {"kind": "velocity", **place}, "z": {"kind": "position", **place}}
    case.table["solver"] = {"t_end": 0.25, "output_step": 1e-4, "rtol": 1e-9}
    case.table["runs"] = {"base": {}}
    result = pm.run(case, out=folder / "ball")
    t, z, v = result.signals["z"].t, result.signals["z"].values, result.signals["v"].values
    fall = float(np.sqrt(2.0 * (height - radius) / 9.81))
    before = int(np.argmax(z < radius)) - 1
    down = (v[before] ** 2 + 2.0 * 9.81 * (z[before] - radius)) ** 0.5  # speed at the floor
    instant = t[before] + (down + v[before]) / 9.81
    after = int(np.argmax((t > fall) & (z > radius)))
    rebound = np.sqrt(v[after] ** 2 + 2.0 * 9.81 * (z[after] - radius))
    return {
        "instant of the impact": float(abs(instant / fall - 1.0)),
        "speed after it over e v": float(abs(rebound / (e * 9.81 * fall) - 1.0)),
    }
