"""Runners, their environments, runs with their cost and error, and truths."""

import hashlib
import importlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import tomllib
import venv
from dataclasses import dataclass, field
from math import ceil
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from processes import cost_of
from scenes import BUILD, HERE, ROOT, Scene

from plymotion.solver.math.arrays import Array
from plymotion.solver.math.disk_cache import sources_sha256

LONGEST = 4.0  # CPU seconds of a process; it is ended, and finer settings of its method left out
DIAGONAL = ("EA", "GA2", "GA3", "GJ", "EI2", "EI3")
FOLDERS = [HERE / "runners"]
SECTION = [  # routes to the truth of sections whose scene names none
    {"code": "ngsolve", "method": "central solutions", "degree": 7},
    {"code": "plymotion", "method": "section", "density": 3.0},
]
KEPT = ("PATH", "HOME", "LANG", "FENICSX_PYTHON", "XDG_CACHE_HOME")  # of the caller's environment
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
# of every process that is timed; bytecode is written and read, as in an installation
ENVIRONMENT = {k: v for k, v in os.environ.items() if k in KEPT} | dict.fromkeys(THREADS, "1")


@dataclass
class Runner:
    """A code: its file, and the Python or program that it runs with."""

    module: ModuleType
    python: str = ""
    version: str = ""
    absent: str = ""  # why it cannot be run here

    @property
    def name(self) -> str:
        """Of the code."""
        return str(self.module.NAME)

    @property
    def key(self) -> str:
        """As scenes name it: that of its file without `in_`, which keeps it apart from the code."""
        return self.module.__name__.removeprefix("in_")


@dataclass
class Trial:
    """One run of a code in one setting."""

    scene: str
    code: str
    setting: dict[str, Any]
    error: float = np.nan
    process_s: float = np.nan
    solution_s: float = np.nan
    failed: str = ""
    found: dict[str, Any] = field(default_factory=dict)

    def row(self) -> dict[str, Any]:
        """As arena.json has it: null for what was not measured."""
        kept = {k: None if v != v else v for k, v in vars(self).items() if k != "found"}
        return kept | {k: self.found[k] for k in ("phases", "steps") if k in self.found}


def runners(install: bool, words: tuple[str, ...] = ()) -> list[Runner]:
    """All runners; with `install`, environments that are missing are made."""
    found = []
    for folder in FOLDERS:
        sys.path.insert(0, str(folder))
        for file in sorted(folder.glob("in_*.py")):
            module = importlib.import_module(file.stem)
            if not words or any(w in file.stem for w in words):
                found.append(environment(Runner(module), install))
    return found


def environment(runner: Runner, install: bool) -> Runner:
    """Find or make the environment of a runner, and its version."""
    wanted = runner.module.ENVIRONMENT
    if "own" in wanted:
        import plymotion

        runner.python, runner.version = sys.executable, plymotion.__version__
    elif "program" in wanted:
        path = shutil.which(wanted["program"])
        runner.version = wanted.get("version", "")
        if not path:
            runner.absent = f"{Path(wanted['program']).name} is not installed: {wanted['how']}"
            return runner
        runner.python = str(Path(path).absolute())
        if not runner.version:
            told = subprocess.run([path, "-v"], capture_output=True, text=True, check=False).stdout
            runner.version = told.strip().splitlines()[-1].split()[-1] if told.strip() else ""
    else:
        folder = BUILD / "environments" / runner.key
        python, mark = folder / "bin/python", folder / "installed.txt"
        if install and not mark.exists():
            venv.create(folder, with_pip=True, clear=True)
            pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
            alone = wanted.get("alone", [])  # without what it asks for
            for asked in filter(None, (wanted["pip"], alone and ["--no-deps", *alone])):
                done = subprocess.run([*pip, *asked], capture_output=True, text=True, check=False)
                if done.returncode:
                    runner.absent = f"pip failed: {done.stderr.strip()[-200:]}"
                    return runner
            name = [*alone, *wanted["pip"]][0].split("==")[0]
            ask = f"import importlib.metadata as m; print(m.version({name!r}))"
            told = subprocess.run(
                [str(python), "-c", ask], capture_output=True, text=True, check=True
            )
            mark.write_text(told.stdout.strip(), encoding="utf-8")
        if mark.exists():
            runner.python, runner.version = str(python.absolute()), mark.read_text()
        else:
            runner.absent = "not installed: `make arena` installs it"
    return runner


def run(
    scene: Scene,
    sheet: dict[str, Any],
    runner: Runner,
    setting: dict[str, Any],
    longest: float | None = LONGEST,
) -> Trial:
    """Run once in a folder of its own; a failure is kept in the trial.

    A process that takes more than `longest` CPU seconds is ended; None: no limit.
    """
    trial = Trial(scene.name, runner.name, setting)
    place = BUILD / "runs" / scene.name
    place.mkdir(parents=True, exist_ok=True)
    words = [str(v) for v in setting.values() if not isinstance(v, dict)]
    name = "-".join(words).replace("/", "_").replace(" ", "")
    folder = Path(tempfile.mkdtemp(prefix=f"{runner.key}-{name}-", dir=place))
    try:
        own = hasattr(runner.module, "prepare")
        # a runner of a stranger's folder finds `common`
        environment = ENVIRONMENT | ({} if own else {"PYTHONPATH": str(HERE / "runners")})
        if own:
            command = runner.module.prepare(sheet, setting, folder, runner.python)
        else:
            job = {"sheet": sheet["sheet"], "setting": setting}
            (folder / "in.json").write_text(json.dumps(job), encoding="utf-8")
            command = [runner.python, str(runner.module.__file__), str(folder)]
        limit = ["prlimit", f"--cpu={ceil(longest)}:"] if longest else []
        inside = ["env", f"--chdir={folder}"] if getattr(runner.module, "INSIDE", False) else []
        used = cost_of([*limit, *inside, *command], environment=environment)
        (folder / "told.txt").write_text(used.told, encoding="utf-8")
        if own:
            trial.found = runner.module.read(sheet, setting, folder)
        else:
            trial.found = json.loads((folder / "out.json").read_text(encoding="utf-8"))
        trial.process_s = used.cpu_s
        trial.solution_s = float(trial.found.get("solution_s", np.nan))
    except (RuntimeError, OSError, KeyError, ValueError) as error:
        lines = [line for line in str(error).splitlines() if line.strip()]
        trial.failed = lines[-1] if lines else type(error).__name__
        killed = "rror" not in trial.failed or "killed by signal" in trial.failed
        trial.failed = trial.failed.replace(f"{ROOT}/", "")
        if killed and longest:  # ended by its limit: no message of an error
            trial.failed = f"more than {longest:g} CPU seconds"
    shutil.rmtree(folder, ignore_errors=True)
    return trial


def values(trial_values: Any) -> Array:
    """Values of a trial: (k, 3) positions, or (k,) numbers in the order of their names."""
    if isinstance(trial_values, dict):
        return np.array([trial_values[key] for key in sorted(trial_values)], dtype=float)
    return np.asarray(trial_values, dtype=float)


def distance(found: Array, true: Array) -> float:
    """Largest distance [m] of positions; largest relative difference of numbers."""
    if found.shape != true.shape or not np.all(np.isfinite(found)):
        return float("inf")
    if found.ndim == 2:
        return float(np.linalg.norm(found - true, axis=1).max())
    return float(np.max(np.abs(found - true) / np.abs(true)))


@dataclass
class Truth:
    """What errors are measured against.

    Attributes
    ----------
    bar : half-width; largest distance [m], or relative
    by : the two routes
    disagree : whether their difference exceeds what the scene promises
    """

    values: Array
    bar: float
    by: str
    disagree: bool = False


def truth(scene: Scene, sheet: dict[str, Any], found: list[Runner]) -> Truth | None:
    """Truth of a scene; None where a code that it needs is not installed."""
    table = scene.table["truth"]
    promised = float(table["bar"])
    if "values" in table:
        return Truth(values(table["values"]), promised, table["by"])
    if "reference" in table:
        file = tomllib.loads((ROOT / table["reference"]).read_text(encoding="utf-8"))
        K = np.diag(np.array(file["verified"]["K"]))
        named = {n: K[DIAGONAL.index(n)] for n in scene.table["values"]}
        return Truth(values(named), promised, table["by"])
    routes: list[tuple[str, Array]] = []
    codes = table.get("codes", [])
    if scene.script is None and scene.table["kind"] == "section":
        codes = codes or SECTION
    if scene.script is not None and hasattr(scene.script, "truth"):
        exact = np.asarray(scene.script.truth(scene.times if scene.motion else None))
        if not codes:
            return Truth(exact, promised, table.get("check", "closed form"))
        routes.append(("closed form", exact))
    for entry in codes:
        runner = next((r for r in found if r.key == entry["code"] and not r.absent), None)
        if runner is None:
            return None
        routes.append((runner.name, converged(scene, sheet, runner, entry)))
    gap = max(distance(v, routes[0][1]) for _, v in routes[1:]) if len(routes) > 1 else promised
    return Truth(routes[0][1], max(gap, 1e-15), " and ".join(n for n, _ in routes), gap > promised)


def converged(scene: Scene, sheet: dict[str, Any], runner: Runner, entry: dict[str, Any]) -> Array:
    """A route to the truth: one setting, or two of which the second has twice the steps.

    With `order`, the limit is extrapolated from both. Kept in build/arena/truths.
    """
    setting = {k: v for k, v in entry.items() if k not in ("code", "order")}
    asked = Path(str(runner.module.__file__)).read_text(encoding="utf-8") + json.dumps(
        [sheet | {"sheet": "", "run_file": "", "run_files": ""}, entry, runner.version],
        sort_keys=True,
    )
    if "own" in runner.module.ENVIRONMENT:
        asked += sources_sha256("solver", "preprocess")
    key = hashlib.sha256(asked.encode()).hexdigest()[:16]
    file = BUILD / "truths" / f"{scene.name}-{entry['code']}-{key}.npy"
    if file.exists():
        return np.asarray(np.load(file))

    def once(setting: dict[str, Any]) -> Array:
        trial = run(scene, sheet, runner, setting, None)
        if trial.failed:
            raise SystemExit(f"{scene.name}: truth by {runner.name} {setting}: {trial.failed}")
        return values(trial.found["values"])

    answer = once(setting)
    if "order" in entry:
        finer = once(setting | {k: 2 * setting[k] for k in ("steps", "elements") if k in setting})
        answer = finer + (finer - answer) / (2 ** entry["order"] - 1)
    file.parent.mkdir(parents=True, exist_ok=True)
    np.save(file, answer)
    return answer
