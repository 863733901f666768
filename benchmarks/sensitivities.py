"""Sensitivities: errors of scenes against six-point differences, and the price of the command.

Errors are the largest over the output times, over the largest derivative of the signal, of runs
with rtol = 1e-8. Prices are CPU times of whole commands, `plymotion sensitivities` over `plymotion
CASE`, with design parameters that change the stiffness of all flexible bodies.

    PYTHONPATH=tests python benchmarks/sensitivities.py build/benchmarks/sensitivities.json
"""

import json
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
from samples.sensitivity_scenes import SCENES, errors

from plymotion.solver.package import read_package, write_package
from plymotion.solver.package.common.design import Derivative

ROOT = Path(__file__).resolve().parents[1]
PRICED = (("robot-arm", "base", (12, 48)), ("double-pendulum", "isotropic", (12,)))


def scene_errors() -> dict[str, float]:
    found = {}
    for name, scene in SCENES.items():
        with tempfile.TemporaryDirectory() as folder:
            found[name] = max(errors(scene, Path(folder), 1e-8).values())
        print(f"{name:26s} {found[name]:.1e}", flush=True)
    return found


def designed(source: Path, target: Path, count: int) -> None:
    """Copy packages, with derivatives of the stiffness by some parameters."""
    random = np.random.default_rng(0)
    target.mkdir()
    for file in source.glob("*.vtkhdf"):
        package = read_package(file)
        root = np.sqrt(np.diag(package.stiffness))
        rates = []
        for k in range(count):
            change = random.normal(size=package.stiffness.shape)
            rate = 0.05 * (change + change.T) * np.outer(root, root)
            rates.append(Derivative(f"a{k}", "number", (), {"modes/stiffness": rate}))
        write_package(target / file.name, replace(package, design=tuple(rates)))


def cpu_time(folder: Path, *words: str) -> float:
    """User and system time of a command [s], the least of two."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    command, found = [sys.executable, "-m", "plymotion.solver", *words], []
    for _ in range(2):
        begin = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, check=True, capture_output=True, cwd=folder, env=environment)
        end = resource.getrusage(resource.RUSAGE_CHILDREN)
        found.append(end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime)
    return min(found)


def prices() -> dict[str, float]:
    found = {}
    for case, run, counts in PRICED:
        for count in counts:
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                shutil.copytree(ROOT / "cases", folder / "cases")
                file = folder / "cases" / case / "case.toml"
                text = re.sub(
                    r'integrator = "[a-z0-9-]+"', 'integrator = "radau"', file.read_text()
                )
                file.write_text(text)
                designed(ROOT / "tests/packages" / case, folder / "packages", count)
                given = (str(file), "--run", run, "--quiet", "--packages", "packages")
                one = cpu_time(folder, "run", *given, "--no-report", "--force")
                keys = [f"a{k}" for k in range(count)]
                all_ = cpu_time(folder, "sensitivities", *given, "--of", *keys)
            found[f"{case}, {count} parameters"] = all_ / one
            print(
                f"{case}, {count} parameters: {one:.2f} s a run, {all_ / one:.2f} runs", flush=True
            )
    return found


if __name__ == "__main__":
    content = {"errors": scene_errors(), "runs": prices()}
    if len(sys.argv) > 1:
        Path(sys.argv[1]).parent.mkdir(parents=True, exist_ok=True)
        Path(sys.argv[1]).write_text(json.dumps(content, indent=1))
