"""Geometric stiffening: what an evaluation costs, and what the soft double pendulum gains.

    python benchmarks/stiffening.py [--cost]

Prints the time of one evaluation of the equations of the double pendulum (two bodies) and of a
rotor (one body that bends in both planes and twists) with linear and with stiffened bodies, medians
of interleaved batches in compiled code, and the errors of the variant `soft-free` against
geometrically exact beams for several frames and modes. `--cost` leaves the errors out, which take
some minutes.
"""

import argparse
import sys
import time
import tomllib
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from samples.beam_samples import coupled_stiffness, reduced  # noqa: E402
from samples.flexible_samples import simulate  # noqa: E402
from samples.stiffening_samples import (  # noqa: E402
    CHORD,
    CLAMPED,
    GRAVITY,
    on_interface,
    soft_modes,
    soft_pendulum,
)

from plymotion.solver.dynamics.evaluation.accelerations import derivative_into  # noqa: E402
from plymotion.solver.dynamics.model.model import (  # noqa: E402
    Model,
    Workspace,
    new_workspace,
)
from plymotion.solver.math.arrays import Array  # noqa: E402
from plymotion.solver.math.compiled import COMPILED, jit  # noqa: E402
from plymotion.solver.math.laws import polynomial  # noqa: E402
from plymotion.solver.mechanism.assembly import assemble_model  # noqa: E402
from plymotion.solver.mechanism.tables import JointTable, MarkerTable, flexible_body  # noqa: E402

BATCHES = 41
CASES = (
    ("chord, 2 static + 2 vibrations", CHORD, soft_modes(2), 1),
    ("the same + static axial", CHORD, soft_modes(2, axial=True), 1),
    ("clamped, 2 vibrations", CLAMPED, soft_modes(2, static=False), 1),
    ("clamped, 3 vibrations", CLAMPED, soft_modes(3, static=False), 1),
    ("arm in two, 2 static + static axial each", CHORD, soft_modes(0, axial=True), 2),
)


@jit
def _many(model: Model, work: Workspace, y: Array, out: Array, count: int) -> None:
    for k in range(count):
        derivative_into(model, work, 1e-6 * k, y, out)


def pendulum_of(n_mode: int) -> tuple[Model, Array]:
    """The soft double pendulum, n modes a body: its bodies bend in a plane."""
    pendulum = soft_pendulum(CHORD, soft_modes(n_mode - 2), elements=16)
    return pendulum.model, pendulum.y0


def rotor_of(n_mode: int) -> tuple[Model, Array]:
    """A driven beam with couplings of all kinds and a mass at its tip."""
    lowest = [{"kind": "lowest", "count": n_mode}]
    beam = reduced(CLAMPED, lowest, elements=8, K=coupled_stiffness())
    body = flexible_body("beam", beam.package, stiffening=True)
    markers = [MarkerTable(-1, np.zeros(3)), *(on_interface(0, beam, at) for at in ("root", "tip"))]
    joints = [
        JointTable("hub", "revolute", 0, 1),
        JointTable("drive", "rotation_drive", 0, 1, polynomial([0.0, 5.0])),
    ]
    model = assemble_model([body], markers, joints, [(2, 0.5)], GRAVITY)
    y = np.zeros(model.n_pos + model.n_vel + 1)
    y[3], y[model.n_pos + 5] = 1.0, 5.0
    return model, y


def cost(stiffened: Model, y: Array) -> tuple[float, float]:
    """Median time of one evaluation, linear and stiffened [us]."""
    linear = stiffened._replace(
        second_start=np.zeros_like(stiffened.second_start),
        marker_second=np.full_like(stiffened.marker_second, -1),
    )
    count = 2000 if COMPILED else 20
    times: dict[int, list[float]] = {0: [], 1: []}
    out = np.empty_like(y)
    y[linear.n_pos :] += 0.1 * np.random.default_rng(0).normal(size=y.size - linear.n_pos)
    works = [new_workspace(linear), new_workspace(stiffened)]
    for _ in range(BATCHES):
        for k, model in enumerate((linear, stiffened)):
            begin = time.process_time()
            _many(model, works[k], y, out, count)
            times[k].append(1e6 * (time.process_time() - begin) / count)
    return float(np.median(times[0][1:])), float(np.median(times[1][1:]))


def errors() -> None:
    """Tip at 1 s and the largest deflection of the arm's middle, frame by frame."""
    file = ROOT / "tests/reference/dynamics/double_pendulum.toml"
    known = tomllib.loads(file.read_text())["isotropic-soft-free"]
    times = np.linspace(0.0, 1.0, 1001)
    turn = 20.0 * times
    print(f"\n{'soft-free':<44}{'tip error [mm]':>16}{'arm mid [%]':>13}{'CPU [s]':>9}")
    for name, reference, modes, arms in CASES:
        pendulum = soft_pendulum(reference, modes, arms=arms)
        begin = time.process_time()
        states = simulate(pendulum.model, pendulum.y0, times, rtol=1e-6)
        spent = time.process_time() - begin
        tip = pendulum.place(pendulum.tip, states[-1])[:2]
        middle = np.array([pendulum.place(pendulum.middle, y) for y in states])
        across = np.cos(turn) * middle[:, 1] - np.sin(turn) * middle[:, 0]
        error = 1e3 * np.linalg.norm(tip - known["tip"])
        share = 100.0 * (np.abs(across).max() / known["arm_mid"] - 1.0)
        print(f"{name:<44}{error:>16.2f}{share:>13.2f}{spent:>9.1f}", flush=True)


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cost", action="store_true", help="only the cost of an evaluation")
    only_cost = parser.parse_args().cost
    print(f"compiled: {COMPILED}; one evaluation, us")
    print(f"{'modes a body':<24}{'linear':>10}{'stiffened':>11}{'added':>8}")
    for name, kind in (("double pendulum", pendulum_of), ("rotor", rotor_of)):
        for n_mode in (2, 4, 6, 8):
            linear, stiffened = cost(*kind(n_mode))
            added = 100.0 * (stiffened / linear - 1.0)
            label = f"{name} {n_mode}"
            print(f"{label:<24}{linear:>10.2f}{stiffened:>11.2f}{added:>7.0f}%", flush=True)
    if not only_cost:
        errors()


if __name__ == "__main__":
    main()
