"""What modes, mesh and mass form do to the motion, as CSV: model errors, not the integrator's.

PYTHONPATH=.:benchmarks .venv/bin/python benchmarks/solver_models.py CSV

Builds the bodies by way of the FEniCSx side (build/fenicsx.env) into build/benchmarks/bodies; one
that is up to date by content is left alone.
"""

import argparse
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from solver_csv import write
from solver_methods import Method, available
from solver_problems import Problem, actuated_beam, chain, from_case
from solver_runs import largest, solve, warm_up
from tqdm import tqdm

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import dump, write_if_changed
from plymotion.solver.math.arrays import Array
from plymotion.solver.package.common.plain_data import inputs_sha256

FOLDER = Path("build/benchmarks/bodies")
FENICSX = Path(os.environ.get("PLYMOTION_FENICSX", "build/fenicsx.env"))
PENDULUM = Path("cases/double-pendulum/case.toml")
BEAM = Path("cases/actuated-beam/case.toml")
# Implicit, so that the highest modes of a fine mesh cost nothing. Radau leaves 1e-9 m or less,
# generalized-alpha some 1e-5 m, in part the same in every variant.
EXACT = available(
    (
        Method("radau", "radau", "projection", (1e-7,)),
        Method("generalized-alpha", "generalized-alpha", "ggl", (1e-5,)),
    )
)[0]
CHAIN, CHAIN_END = 4, 0.5  # links, [s]
ELEMENTS = (4, 8, 16, 32, 64)
FINE = 128
MODES = (1, 2, 3, 4, 6)
MANY = 8
MESH_OF_MODES = 32
FORMS = ("lumped", "consistent")


@dataclass(frozen=True)
class Variant:
    """A body's discretisation."""

    elements: int
    mass_form: str
    n_mode: int
    attachment: bool = True  # of the actuated beam

    @property
    def stem(self) -> str:
        """Part of the file's name."""
        extra = "" if self.attachment else "-bare"
        return f"{self.elements}-{self.mass_form}-{self.n_mode}{extra}"


def write_spec(case: Path, run: str, body: str, variant: Variant) -> Path:
    """Write the specification of a body as the case has it but for the variant."""
    spec: dict[str, Any] = dict(load_case(case).bodies[run][body].content)
    modes = []
    for choice in spec["modes"]:
        if choice["kind"] == "attachment" and not variant.attachment:
            continue
        first = choice["kind"].startswith("bending") and not modes
        modes.append(choice | {"count": variant.n_mode} if first else choice)
    spec |= {"elements": variant.elements, "mass_form": variant.mass_form, "modes": modes}
    file = FOLDER / f"{body}-{variant.stem}.json"
    write_if_changed(file, dump({**spec, "inputs_sha256": inputs_sha256(spec)}))
    return file


def package(body: str, variant: Variant) -> Path:
    """File of a built body."""
    return FOLDER / f"{body}-{variant.stem}.vtkhdf"


def pendulum(variant: Variant) -> Problem:
    """Double pendulum of both links in one variant."""
    files = {body: package(body, variant) for body in ("arm", "hand")}
    return from_case(PENDULUM, "isotropic", files, ("hand", "tip"), 1.0)


def build(specs: list[Path]) -> None:
    """Build all bodies in one process of the FEniCSx side."""
    if not FENICSX.exists():
        raise SystemExit(f"{FENICSX}: not there: run `make fenicsx` first")
    names = " ".join(map(str, specs))
    command = f'. {FENICSX.resolve()} && "$FENICSX_PYTHON" -m plymotion.preprocess body'
    command += f" {names} --out-dir {FOLDER}"
    subprocess.run(["sh", "-c", command], check=True, env=os.environ | {"PYTHONPATH": str(Path())})


def studies() -> list[tuple[str, str, Variant, list[tuple[str, int, Variant]]]]:
    """(study, problem, reference, [(curve, number on the axis, variant)])."""
    found = []
    for problem, count in (("double-pendulum", 4), ("actuated-beam", 4)):
        mesh = [(form, n, Variant(n, form, count)) for form in FORMS for n in ELEMENTS]
        found.append(("mesh", problem, Variant(FINE, "consistent", count), mesh))
    for problem in ("double-pendulum", f"chain-{CHAIN}"):
        modes = [("bending modes", n, Variant(MESH_OF_MODES, "consistent", n)) for n in MODES]
        found.append(("modes", problem, Variant(MESH_OF_MODES, "consistent", MANY), modes))
    beams = [
        (name, n, Variant(MESH_OF_MODES, "consistent", n, attachment))
        for name, attachment in (("with attachment mode", True), ("bending modes only", False))
        for n in MODES
    ]
    best = Variant(MESH_OF_MODES, "consistent", MANY)
    found.append(("modes", "actuated-beam", best, beams))
    return found


def problem_of(name: str, variant: Variant) -> Problem:
    """Problem of a name with its bodies in a variant."""
    if name == "double-pendulum":
        return pendulum(variant)
    if name == "actuated-beam":
        return actuated_beam(package("beam", variant))
    return chain(CHAIN, CHAIN_END, package("hand", variant))


def specs_of(name: str, variant: Variant) -> list[Path]:
    """Specifications of a problem's bodies."""
    if name == "actuated-beam":
        return [write_spec(BEAM, "layup-1", "beam", variant)]
    bodies = ("arm", "hand") if name == "double-pendulum" else ("hand",)
    return [write_spec(PENDULUM, "isotropic", body, variant) for body in bodies]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("csv", type=Path)
    arguments = parser.parse_args()
    specs: dict[Path, None] = {}
    for _, name, best, points in studies():
        for variant in [best, *(v for _, _, v in points)]:
            specs |= dict.fromkeys(specs_of(name, variant))
    build(list(specs))
    rows: list[dict[str, object]] = []
    for study, name, best, points in studies():
        finest = problem_of(name, best)
        warm_up(finest, [EXACT])
        exact = _solved(finest)[0]
        for curve, number, variant in tqdm(points, desc=f"{study}, {name}"):
            problem = problem_of(name, variant)
            places, cpu = _solved(problem)
            rows.append(
                {
                    "study": study,
                    "problem": name,
                    "curve": curve,
                    "number": number,
                    "error": largest(places, exact),
                    "cpu_s": cpu,
                }
            )
    write(arguments.csv, rows)


def _solved(problem: Problem) -> tuple[Array, float]:
    """Path of the probe, and processor time [s]."""
    result, summary, cpu = solve(problem.with_solver(EXACT, EXACT.rtols[0]))
    if summary["status"] != "finished":
        raise SystemExit(f"{problem.name}: {summary['message']}")
    return problem.places(result), cpu


if __name__ == "__main__":
    main()
