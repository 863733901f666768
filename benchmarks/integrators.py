"""Cost and error of the integrators on one run of the double pendulum (docs/adr/0005).

make double-pendulum && .venv/bin/python benchmarks/integrators.py
"""

import time
from pathlib import Path

import numpy as np

from plymotion.solver import recover
from plymotion.solver.ahead import compile_ahead
from plymotion.solver.initial import consistent_state
from plymotion.solver.integrate import integrate
from plymotion.solver.mechanism import build
from plymotion.solver.run import make_integrator, output_times, read_run
from plymotion.solver.signals import Recording, sensors

RUN = Path("build/double-pendulum/runs/isotropic.json")
T_END = 0.3
CHOICES = [
    {"integrator": "rk8", "rtol": 1e-10},
    {"integrator": "rk8", "rtol": 1e-6},
    {"integrator": "rk8", "rtol": 1e-4},
    {"integrator": "rk5", "rtol": 1e-5},
    {"integrator": "gear", "rtol": 1e-5},
    {"integrator": "gear", "rtol": 1e-4},
    {"integrator": "gear", "rtol": 1e-4, "max_order": 2},
]


def main() -> None:
    compile_ahead()
    spec = read_run(RUN)
    reference = None
    print("integrator  order  rtol   steps  evaluations  CPU [s]  |hand_mid| error  joint gap [m]")
    for choice in CHOICES:
        rtol = choice["rtol"]
        spec.mechanism["solver"].update(
            {"t_end": T_END, "max_order": 5, "atol_position": 1e-2 * rtol, "atol_velocity": rtol}
            | choice
        )
        solver = spec.mechanism["solver"]
        built = build(spec.mechanism, spec.packages)
        y0 = consistent_state(built.model, built.start, built.joint_names)
        begin = time.process_time()
        integrator = make_integrator(built.model, y0, solver)
        solution = integrate(integrator, output_times(T_END, solver["output_step"]))
        cpu = time.process_time() - begin
        sensor = sensors(built, spec.mechanism["signals"])["hand_mid"]
        hand = sensor.values(Recording(built.model, solution.t, solution.y))
        largest = np.abs(hand).max()
        reference = largest if reference is None else reference
        gap = recover.history(built.model, solution.t, solution.y).position_violation.max()
        c = solution.counters
        print(
            f"{solver['integrator']:10s}  {solver['max_order']:5d}  {rtol:5.0e}  {c.steps:5d}  "
            f"{c.evaluations:11d}  {cpu:7.2f}  {abs(largest / reference - 1):16.1e}  {gap:13.1e}"
        )


if __name__ == "__main__":
    main()
