"""Joints at flexible bodies by markers and by virtual bodies: size, time, difference of motion.

make double-pendulum && .venv/bin/python benchmarks/attachment.py
"""

import time
from pathlib import Path

import numpy as np

from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.studies.compiling import compile_ahead

RUN = Path("build/double-pendulum/runs/isotropic.json")
T_END = 0.1


def main() -> None:
    compile_ahead()
    settings = {"t_end": T_END, "rtol": 1e-9, "atol_position": 1e-12, "atol_velocity": 1e-10}
    base = read_run(RUN).changed({f"solver.{key}": value for key, value in settings.items()})
    print(f"double pendulum, isotropic, {T_END} s, rk8, rtol 1e-9")
    print("attachment  unknowns  equations  evaluations  CPU [s]  us / evaluation")
    tips = []
    for how in ("marker", "virtual"):
        spec = base.changed({"solver.attachment": how})
        begin = time.process_time()
        result, summary = execute(spec, progress=False)
        cpu = time.process_time() - begin
        cost = summary["cost"]
        tips.append([s.values for s in result.signals if s.name in ("tip_x", "tip_y")])
        print(
            f"{how:10s}  {result.v.shape[1]:8d}  {result.multipliers.shape[1]:9d}  "
            f"{cost['evaluations']:11d}  {cpu:7.2f}  {1e6 * cpu / cost['evaluations']:15.1f}"
        )
    print(f"largest difference of the tip's path: {np.abs(np.subtract(*tips)).max():.1e} m")


if __name__ == "__main__":
    main()
