"""Robots of the wheel `example-robot-data`: equations in joint coordinates against Pinocchio's.

    make robots      writes build/benchmarks/robots.json

For each file, with its root fixed and free: the largest difference of mass matrix, bias and gravity
forces over random states, relative to their largest entry. A file that the import refuses has its
message. PYTHON is one with the wheels `pin` and `example-robot-data`. Before these, steps of 1 ms
and what robots_exchange.py has.
"""

import argparse
import json
import subprocess
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from robots_exchange import READY, ROOT, TORQUES, contact, driven_arm, fmi, mujoco, orders

import plymotion as pm
from plymotion.solver.dynamics.analysis.joint_coordinates import JointCoordinates
from plymotion.solver.dynamics.model.model import state_size
from plymotion.solver.errors import InputError
from plymotion.solver.extras.robot.case import robot_case, start
from plymotion.solver.extras.robot.urdf import read_urdf
from plymotion.solver.math.rotations import matrix_to_vector
from plymotion.solver.mechanism.build import build

HERE = Path(__file__).parent
ALLOWED = ("inertia", "units")  # files of others are taken as they are
ROBOTS = "cmeel.prefix/share/example-robot-data/robots"  # in the site packages of the wheels
FIXED = (2.5e-4, 5e-4, 1e-3)  # fixed steps [s]
RESOLVED = {"cutoff_frequency": 0.0}
WAYS = (
    (None, {"rtol": 1e-8, **RESOLVED}),
    (None, {"rtol": 1e-5, **RESOLVED}),
    *((None, {"rtol": rtol}) for rtol in (1e-6, 1e-5, 1e-4)),
    *((h, {"rtol": 1e-5}) for h in FIXED),
)
# Of torques that are noise. With fixed steps `rtol` ends Newton's iteration, nothing else.
NOISE_WAYS = (
    (None, {"rtol": 1e-7, **RESOLVED}),
    *((None, {"rtol": rtol}) for rtol in (1e-5, 1e-4)),
    *((h, {"rtol": 1e-3}) for h in (2.5e-4, 1e-3 / 3.0, 5e-4)),
)
WHERE = "import sysconfig; print(sysconfig.get_path('purelib'))"


def compared(file: Path, base: str, peer: str, count: int, folder: str) -> dict[str, float]:
    """Return the largest relative differences of a file."""
    robot = read_urdf(file)
    made = robot_case(robot, joints="free", base=base, allow=ALLOWED)
    table = {k: v for k, v in made.tables.items() if k not in ("format", "title", "runs", "forces")}
    mechanism = pm.Case("robot", **table).check().runs["base"]
    built = build(mechanism, {})
    offsets = {name: joint.shift for name, joint in built.joints.items()}
    ours = JointCoordinates(built.model, built.body_names, built.joint_names, offsets)
    y = np.zeros(state_size(built.model))

    out = f"{folder}/peer.npz"
    script = [peer, str(HERE / "robots_pinocchio.py"), out, str(file)]
    done = subprocess.run(
        [*script, "--root", base, "--states", str(count)], capture_output=True, text=True
    )
    if done.returncode:
        raise RuntimeError(done.stderr.strip().splitlines()[-1])
    theirs = np.load(out)
    names = [str(name) for name in theirs["names"]]
    column = {name.rsplit(".", 1)[0]: k for k, name in enumerate(ours.names)}
    place = [column[made.names[f"joint {name}"]] for name in names]
    zero = np.array([start(robot, robot.joints[name]) for name in names])
    frame = [k for k in range(len(ours.names)) if k not in place]  # of a free root
    order = np.array([*frame, *place], dtype=int)
    n, worst = len(order), dict.fromkeys(("M", "bias", "gravity"), 0.0)
    for k in range(count):
        values, v = np.zeros(n), np.zeros(n)
        values[place] = theirs["values"][k] - zero
        T, turning = np.eye(n), np.zeros(n)  # Pinocchio's rates by ours
        if frame:
            A, u = theirs["A"][k], theirs["rates"][k]
            values[frame] = [*theirs["r"][k], *matrix_to_vector(A)]
            T[:3, :3] = A.T
            turning[:3] = -np.cross(u[3:6], u[:3])
        v[order] = np.linalg.solve(T, theirs["rates"][k])
        found = ours.projected(0.0, ours.state(0.0, y, values, v))
        still = ours.projected(0.0, ours.state(0.0, y, values, np.zeros(n)))
        M = theirs["M"][k]
        # where forces vanish by symmetry: a thousandth of what such masses can have
        size, speed = float(np.abs(M).max()), float(np.abs(v).max())
        weight = 9.81 * np.sqrt(size * built.model.mass.sum())
        for key, a, b, scale in (
            ("M", found.M[np.ix_(order, order)], T.T @ M @ T, size),
            ("bias", found.c[order], T.T @ (theirs["c"][k] + M @ turning), size * speed**2),
            ("gravity", still.c[order], T.T @ theirs["g"][k], weight),
        ):
            gap = float(np.abs(a - b).max() / max(float(np.abs(b).max()), 1e-3 * scale))
            worst[key] = max(worst[key], gap)
    return {"coordinates": n, **worst}


def stepping(folder: str, ways: Any, torques: Any, chunks: int = 6, count: int = 50) -> object:
    """Return the CPU time of a step of 1 ms of the arm with two flexible links [s].

    Motors in the six joints are inputs, which jump at every step. By accuracy, with rates of fast
    vibrations resolved or not, or with fixed steps. Errors are differences from the first run. The
    shortest mean of `count` steps: on a busy machine others are longer.

    Parameters
    ----------
    folder : folder of the runs
    ways : fixed step, or None, and the keys of the solver of each run
    torques : (chunks * count, 6) of the motors [N m]
    chunks, count : timings, and steps of each
    """
    result: dict[str, dict[str, float]] = {}
    exact = np.zeros((2, 6))
    for fixed, solver in ways:
        case = driven_arm(**solver)
        case.table["signals"] = {}
        sim = pm.simulate(case, "tubes", out=folder, packages=READY, fixed_step=fixed)
        found: list[float] = []
        for chunk in torques.reshape(chunks, count, 6):
            begin = time.process_time()
            for torque in chunk:
                sim.step(1e-3, torque)
            found.append((time.process_time() - begin) / count)
        ends = np.array([sim.q[:6], sim.qd[:6]])
        exact = exact if result else ends
        errors = np.abs(ends - exact).max(axis=1)
        keys = {**({"fixed_step": fixed} if fixed else {}), **solver}
        result[", ".join(f"{key} {value:g}" for key, value in keys.items())] = {
            "modes": len(sim.coordinates) - 6,
            "cpu_s_per_step": min(found),
            "largest_error_of_an_angle": float(errors[0]),
            "largest_error_of_a_rate": float(errors[1]),
        }
    return result


def main() -> None:
    """Compare all files and write the JSON."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--python", required=True)
    parser.add_argument("--out", type=Path, default=Path("build/benchmarks/robots.json"))
    parser.add_argument("--states", type=int, default=100)
    parser.add_argument("--only", default="", help="files with this in their path")
    options = parser.parse_args()
    package = subprocess.run([options.python, "-c", WHERE], capture_output=True, text=True)
    root = Path(package.stdout.strip()) / ROBOTS
    result: dict[str, object] = {}
    with tempfile.TemporaryDirectory() as folder:
        t, noise = (
            1e-3 * np.arange(300)[:, None],
            np.random.default_rng(0).uniform(-1.0, 1.0, (300, 6)),
        )
        waves = np.sin(10.0 * t + np.arange(6))
        result["steps of 1 ms"] = stepping(folder, WAYS, TORQUES * waves)
        result["steps of 1 ms, noise"] = stepping(folder, NOISE_WAYS, TORQUES * noise)
        drawn = partial(orders, picture=ROOT / "docs/pictures/fmu-orders.png")
        parts = {"FMI": fmi, "orders of FMUs": drawn, "MuJoCo": mujoco, "contact": contact}
        for key, found_by in parts.items():
            try:
                result[key] = found_by(Path(folder))
            except ModuleNotFoundError as error:  # of programs that could not be installed
                result[key] = {"left out": str(error)}
        print(result, flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for file in sorted(root.rglob("*.urdf")):
            name = str(file.relative_to(root))
            if options.only not in name:
                continue
            for base in ("fixed", "free"):
                try:
                    found: object = compared(file, base, options.python, options.states, folder)
                except (InputError, RuntimeError) as error:
                    found = {"refused": str(error).replace(f"{root}/", "")}
                result[f"{name}, {base} root"] = found
                print(name, base, found, flush=True)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
