"""The arena: scenes with truths, every code that can be run here, error against time, who wins.

python benchmarks/arena/arena.py [--quick] [--no-install] [--out DIR] [--scenes DIR] [--runners DIR]
    [--write docs/arena.md] [--coverage N] [--longest S] [--thin N]
    [--lanes N] [WORD ...]

Writes DIR/arena.json and DIR/index.html with charts. Words choose scenes whose names contain one
of them. `--scenes` and `--runners` add a folder of scenes or runners of your own (docs/arena.md).
`--page` draws the page again from DIR/arena.json, with a map of stability if it lacks one. Times
are CPU seconds (user and system).
"""

import argparse
import json
import math
import os
import resource
import sys
from collections import Counter
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parents[1]), str(HERE.parents[1] / "tests")]
os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import frame  # noqa: E402
import page  # noqa: E402
import scenes  # noqa: E402
import stability  # noqa: E402
from tqdm import tqdm  # noqa: E402

LANES = 2  # processes that run beside each other: as many as two quiet cores take
QUICK_LONGEST = 3.0  # CPU seconds of a process after which finer settings are left out


def main() -> None:
    """Measure, write arena.json and the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="scenes with quick = true")
    parser.add_argument("--no-install", action="store_true")
    parser.add_argument("--page", action="store_true")
    parser.add_argument("--out", type=Path, default=scenes.BUILD)
    parser.add_argument("--scenes", type=Path)
    parser.add_argument("--runners", type=Path)
    parser.add_argument("--codes", default="", help="only these, as in runners/in_NAME.py")
    parser.add_argument("--longest", type=float, help="CPU seconds after which a process is ended")
    parser.add_argument("--thin", type=int, default=1, help="only every Nth setting of a method")
    parser.add_argument("--lanes", type=int, default=LANES, help="processes at a time")
    parser.add_argument("--coverage", type=int, default=0, help="random scenes of the error bars")
    parser.add_argument("--write", type=Path, help="renew the tables of this page of docs")
    parser.add_argument("words", nargs="*")
    told = parser.parse_args()
    told.out.mkdir(parents=True, exist_ok=True)
    file = told.out / "arena.json"
    if told.runners:
        frame.FOLDERS.append(told.runners)
    install = not (told.no_install or told.page)
    codes = frame.runners(install, tuple(filter(None, told.codes.split(","))))
    if told.page:
        results = json.loads(file.read_text(encoding="utf-8"))
    else:
        places = [HERE / "scenes", *([told.scenes] if told.scenes else [])]
        chosen = scenes.find(places, tuple(told.words))
        if told.quick:
            chosen = [scene for scene in chosen if scene.table.get("quick")]
        chosen.sort(key=lambda scene: not scene.table.get("quick"))
        longest = told.longest or (QUICK_LONGEST if told.quick else frame.LONGEST)
        limits = {"longest": longest, "thin": told.thin, "lanes": told.lanes}
        results = measured(chosen, codes, limits, file) | {"settings": limits}
        cpu = results["cpu_s"] = {"scenes": cpu_s()}
        if told.coverage:
            import covered

            results |= covered.measured(told.coverage, told.lanes)
            cpu["error bars"] = cpu_s() - sum(cpu.values())
        file.write_text(json.dumps(results, indent=1), encoding="utf-8")
    if not (told.quick or told.words) and "stability" not in results:
        before = cpu_s()
        results["stability"] = stability.measured(codes)
        results.setdefault("cpu_s", {})["stability"] = cpu_s() - before
    file.write_text(json.dumps(results, indent=1), encoding="utf-8")
    page.write(results, told.out)
    if told.write:
        page.write_docs(results, told.write)
    print(f"{file}, {told.out / 'index.html'}")


def cpu_s() -> float:
    """CPU seconds of this process and of all that it has waited for."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(u.ru_utime + u.ru_stime for u in used)


def measured(
    chosen: list[scenes.Scene], codes: list[frame.Runner], limits: dict[str, Any], file: Path
) -> dict[str, Any]:
    """Everything that arena.json has, except the coverage of error bars.

    The file is written after each scene: a run that is ended keeps what it has.
    """
    sheets = [scene.sheet() for scene in tqdm(chosen, unit="sheet")]
    versions = {r.name: r.version or "absent" for r in codes}
    found: dict[str, Any] = {
        "scenes": len(chosen),
        "codes": [f"{name} {version}" for name, version in versions.items()],
        "truths": {},
        "coverage": None,
        "bar_over_error_median": None,
        "about": {scene.name: about(scene) for scene in chosen},
        "truth_by": {},
        "cannot": {},
        "trials": [],
    }
    with ThreadPoolExecutor(limits["lanes"]) as pool, tqdm(unit="job", total=len(chosen)) as shown:
        # first the truth of a scene, then each code by itself
        jobs: dict[Future[Any], tuple[scenes.Scene, dict[str, Any], bool]] = {
            pool.submit(truth_of, scene, sheet, codes): (scene, sheet, True)
            for scene, sheet in zip(chosen, sheets, strict=True)
        }
        while jobs:
            job = next(as_completed(jobs))
            scene, sheet, first = jobs.pop(job)
            shown.update()
            if not first:
                found["trials"] += [trial.row() for trial in job.result()]
            elif isinstance(truth := job.result(), str):
                found["cannot"][scene.name] = {"truth": truth}
            else:
                found["truths"][scene.name] = truth.bar
                by = {"bar": truth.bar, "by": truth.by, "disagree": truth.disagree}
                found["truth_by"][scene.name] = by
                reasons = {r.name: r.absent or r.module.cannot(sheet) for r in codes}
                if cannot := {name: why for name, why in reasons.items() if why}:
                    found["cannot"][scene.name] = cannot
                able = [r for r in codes if not reasons[r.name]]
                shown.total += len(able)
                for r in able:
                    new = pool.submit(trials, scene, sheet, r, truth, limits)
                    jobs[new] = (scene, sheet, False)
            order = [scene.name for scene in chosen]
            found["trials"].sort(key=lambda row: (order.index(row["scene"]), row["code"]))
            for key in ("truths", "truth_by", "cannot"):
                found[key] = {name: found[key][name] for name in order if name in found[key]}
            found |= page.verdicts(found["trials"], found["truths"])
            file.write_text(json.dumps(found, indent=1), encoding="utf-8")
    return found


def truth_of(
    scene: scenes.Scene, sheet: dict[str, Any], codes: list[frame.Runner]
) -> frame.Truth | str:
    """Truth of a scene, or why there is none."""
    try:
        return frame.truth(scene, sheet, codes) or "a code that it needs is not installed"
    except SystemExit as error:
        return str(error).replace(f"{scenes.ROOT}/", "")


def about(scene: scenes.Scene) -> dict[str, Any]:
    """What the page says of a scene."""
    kept = ("title", "kind", "source", "licence", "unit", "note")
    return {k: scene.table[k] for k in kept if k in scene.table}


def trials(
    scene: scenes.Scene,
    sheet: dict[str, Any],
    runner: frame.Runner,
    truth: frame.Truth,
    limits: dict[str, Any],
) -> list[frame.Trial]:
    """Settings of a runner; of each method no finer ones after one that failed or took too long.

    Neither after an error below the bar of the truth, where nothing is compared. The first setting
    runs twice, and the second run counts: files are in memory, bytecode and compiled code exist.
    """
    longest = max(limits["longest"], scene.table.get("longest", 0.0))
    found: list[frame.Trial] = []
    over, seen = set(), Counter[str]()
    for setting in runner.module.settings(sheet):
        seen[setting["method"]] += 1
        if setting["method"] in over or (seen[setting["method"]] - 1) % limits["thin"]:
            continue
        if not found:
            frame.run(scene, sheet, runner, setting, longest)
        trial = frame.run(scene, sheet, runner, setting, longest)
        found.append(trial)
        if not trial.failed:
            values = frame.values(trial.found["values"])
            trial.error = frame.distance(values, truth.values)
            if not math.isfinite(trial.error):
                trial.failed = "not finite, or not all outputs"
        if trial.failed or trial.error <= truth.bar:
            over.add(setting["method"])
    return found


if __name__ == "__main__":
    main()
