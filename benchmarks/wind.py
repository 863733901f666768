"""A turbine in the wind against the operation that HAWCStab2 has for it.

    make wind      writes build/benchmarks/wind.json

`plymotion blade FILE --rotor` writes the case of IEA-15-240-RWT of the package windIO. It runs 80 s
at 12 wind speeds, with three blades of the full 6x6, tower and controller; numbers are means over
the last whole revolutions of 30 s. The least pitch is that of the reference. Then the same at the
speed and pitch of HAWC2, and of OpenFAST with BeamDyn, which the controller has no part in: power,
thrust and deflection of the tip. Then a step of the wind by 2 m/s. Frequencies of the turning blade
are compared with those of HAWCStab2.
"""

import argparse
import csv
import json
import math
import os
import re
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import numpy as np

from plymotion.solver.errors import InputError
from plymotion.solver.run.execution import execute, read_run

REFERENCE = Path("tests/reference/dynamics/iea15_hawcstab2.toml")
SIGNALS = ("power", "thrust", "pitch", "speed", "flap", "edge")
COMPARED = ("pitch_deg", "speed", "power", "thrust", "flap")  # with programs, at their points
T_END, LAST = 80.0, 30.0  # [s]
T_HELD = 50.0  # [s]
HOLD = 1e9  # [N m s] of a generator that holds a speed


def command(*words: str) -> None:
    """Run plymotion."""
    subprocess.run([sys.executable, "-m", "plymotion.solver", *words], check=True)


def means(result, speed: float) -> dict[str, float]:
    """Return means of the signals over the last whole revolutions, and the swing of the pitch."""
    period = 2.0 * math.pi / speed
    length = math.floor(LAST / period) * period
    kept = result.t >= result.t[-1] - length
    values = {s.name: s.values[kept] for s in result.signals}
    found = {name: float(values[name].mean()) for name in SIGNALS}
    return found | {"pitch_swing": float(np.ptp(values["pitch"]))}


def prepared(folder: Path, name: str, parameters: dict[str, float], induction: str, law: str = ""):
    """Return a run of the case with other parameters, on which starting values depend.

    law : of the generator, in place of that of the case
    """
    text = (folder / "turbine/rotor.toml").read_text()
    for key, value in parameters.items():
        text = re.sub(rf"(?m)^{key} = \S+", f"{key} = {value!r}", text, count=1)
    text = re.sub(r"(?m)^induction = \S+", f'induction = "{induction}"', text, count=1)
    if law:
        text = re.sub(r'(?m)(joint = "shaft"\nexpression = ).*', rf'\1"{law}"', text)
    case = folder / "turbine/point.toml"
    case.write_text(text)
    command("check", str(case), "--out", str(folder / "out"))
    file = folder / f"out/runs/{name}.json"
    command("packages", str(file), "--quiet")
    return read_run(file)


def run(spec, t_end: float):
    """Return result and cost of a run: CPU seconds per second of motion."""
    begin = time.process_time()
    result, summary = execute(spec.changed({"solver.t_end": t_end}), progress=False)
    cost = (time.process_time() - begin) / float(result.t[-1])
    if not summary["completed"]:
        raise RuntimeError(summary["message"])
    return result, cost


def held(folder: Path, wind: float, induction: str, known: dict[str, float]) -> dict[str, float]:
    """Return a run at the speed and pitch of a program, compared with it."""
    pitch, torque = math.radians(known["pitch_deg"]), known["power"] / known["speed"]
    start = {
        "wind": wind,
        "speed": known["speed"],
        "pitch_deg": known["pitch_deg"],
        "fine_pitch": pitch,
        "rated_speed": 10.0,  # so that the pitch stays the least
    }
    law = f"-{torque!r} - {HOLD:g} * (v - speed)"
    spec = prepared(folder, "steady", start, induction, law)
    try:
        result, _ = run(spec, T_HELD)
    except InputError:  # the shapes of the start do not converge at every pitch
        result, _ = run(spec.changed({"solver.start": "positions"}), T_HELD)
    point = {"wind": wind, **means(result, known["speed"])}
    for key in ("power", "thrust", "flap", "speed"):
        point[f"{key}_error"] = point[key] / known[key] - 1.0
    point["pitch_error_deg"] = math.degrees(point["pitch"]) - known["pitch_deg"]
    point["flap_difference"] = point["flap"] - known["flap"]
    return point


def turning(folder: Path, known: dict[str, list[float]]) -> list[dict[str, float]]:
    """Return frequencies of a blade on its turning hub [Hz], compared with those of the turbine."""
    first, second = known["speed"]
    at = ["--at", f"spin={first}:{second}:{second - first}", "--count", "2", "--quiet"]
    command("modes", str(folder / "turbine/case.toml"), *at, "--out", str(folder / "modes"))
    branches = json.loads((folder / "modes/campbell.json").read_text())["branches"]
    found = []
    for k, speed in enumerate(known["speed"]):
        point = {"speed": speed}
        for key, branch in zip(("flap_hz", "edge_hz"), branches, strict=True):
            point[key] = branch["angular_frequency"][k] / (2.0 * math.pi)
            point[f"{key}_error"] = point[key] / known[key][k] - 1.0
        found.append(shown(point))
    return found


def shown(point: dict[str, float]) -> dict[str, float]:
    """Print a row and return it."""
    print("  ".join(f"{key} {value:.4g}" for key, value in point.items()), flush=True)
    return point


def main() -> None:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("turbine", type=Path, help="windIO file of IEA-15-240-RWT")
    parser.add_argument("--out", type=Path, default=Path("build/benchmarks/wind.json"))
    parser.add_argument("--stations", default="21")
    parser.add_argument("--induction", default="madsen", help="of the runs with the controller")
    options = parser.parse_args()
    folder = options.out.with_suffix("")
    words = ["--stations", options.stations, "--no-estimate", "--rotor", "--quiet"]
    command("blade", str(options.turbine), *words, "-o", str(folder / "turbine"))
    reference = tomllib.loads(REFERENCE.read_text())
    points = []
    with (folder / "turbine/operation.csv").open() as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    for row in rows:
        k = reference["wind"].index(row["wind_m_s"])
        below_rated = row["wind_m_s"] < 10.5
        pitch = reference["pitch_deg"][k] if below_rated else row["pitch_deg"]
        start = {
            "wind": row["wind_m_s"],
            "speed": row["speed_rpm"] * math.pi / 30.0,
            "pitch_deg": pitch,
            "fine_pitch": math.radians(pitch) if below_rated else 0.0,
        }
        result, cost = run(prepared(folder, "steady", start, options.induction), T_END)
        point = {"wind": row["wind_m_s"], **means(result, start["speed"]), "cpu_s_per_s": cost}
        for key in ("power", "thrust", "speed"):
            point[f"{key}_error"] = point[key] / reference[key][k] - 1.0
        point["pitch_error_deg"] = math.degrees(point["pitch"]) - reference["pitch_deg"][k]
        points.append(shown(point))
    programs = {"turning": turning(folder, reference["turning"])}
    for name in ("hawc2", "beamdyn"):
        table = reference[name]
        print(name)
        programs[name] = [
            shown(held(folder, wind, table["induction"], {key: table[key][k] for key in COMPARED}))
            for k, wind in enumerate(reference["wind"])
        ]
    result, cost = run(prepared(folder, "step", {}, options.induction), 100.0)
    values = {s.name: s.values for s in result.signals}
    after = result.t > 60.0
    step = {
        "highest_speed": float(values["speed"][after].max()),
        "speed_at_end": float(values["speed"][-100:].mean()),
        "pitch_swing_last_20_s": float(np.ptp(values["pitch"][-200:])),
        "cpu_s_per_s": cost,
    }
    print(step)
    machine = {"cores": os.cpu_count(), "load": os.getloadavg()[0]}
    text = json.dumps({"points": points, **programs, "step": step, "machine": machine}, indent=1)
    options.out.write_text(text + "\n")


if __name__ == "__main__":
    main()
