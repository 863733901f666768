"""The benchmark's double pendulum in Exudyn as a whole process: import, build, solve, write.

python benchmarks/exudyn_process.py BODIES T_END STEPS NEWTON EVERY FOLDER

BODIES is the file written by solver_processes.py: the arrays of both links. Writes all coordinates
and the path of the tip, every EVERY seconds, into FOLDER, and the seconds of each phase.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np
from exudyn_plane import Reduced, double_pendulum, exudyn


def main() -> None:
    bodies, t_end, steps, newton, every, folder = sys.argv[1:]
    marks = [time.process_time()]
    exudyn()
    marks.append(time.process_time())
    with np.load(bodies) as arrays:
        arm, hand = (
            Reduced(**{k.split("/")[1]: v for k, v in arrays.items() if k.startswith(body)})
            for body in ("arm", "hand")
        )
    plane, _ = double_pendulum(arm, hand, file=f"{folder}/tip.txt")
    marks.append(time.process_time())
    cpu = plane.solve(
        float(t_end), int(steps), newton, every=float(every), file=f"{folder}/coordinates.txt"
    )
    seconds = {"import": marks[1], "build": marks[2] - marks[1], "solve and write": cpu}
    Path(folder, "seconds.json").write_text(json.dumps(seconds), encoding="utf-8")


if __name__ == "__main__":
    main()
