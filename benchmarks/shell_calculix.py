r"""Laminated shells by CalculiX: input decks, real runs of `ccx`, its numbers.

PYTHONPATH=tests .venv/bin/python benchmarks/shell_calculix.py [--write JSON]

runs the box beams and cantilever plates of tests/reference/shells/benchmarks.toml (ids `ccx_*`)
with S8R and prints each number beside the stored one. `ccx` comes with `apt-get install
calculix-ccx`; where it is absent the script says so and ends with exit code 0.

Decks are composite shell sections (one layer of solid elements per ply after CalculiX's own
expansion), rectangular grids of S8R or S6 elements. Times are seconds of processor of the child.
"""

import argparse
import json
import resource
import shutil
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from samples.shell_layups import (
    BOX_MATERIAL,
    BOXES,
    HEIGHT,
    LENGTH,
    PLATE_LENGTH,
    PLATE_MATERIAL,
    PLATE_PLY,
    PLATE_WIDTH,
    PLATES,
    WALL,
    WIDTH,
)

Array = NDArray[np.float64]
HERE = Path(__file__).resolve().parent
REFERENCE = HERE.parent / "tests" / "reference" / "shells" / "benchmarks.toml"
ABSENT = "ccx is not installed (apt-get install calculix-ccx): CalculiX's numbers are left out"


class Wall(NamedTuple):
    """Elements with one stack of plies."""

    elements: list[list[int]]  # rows of points, in CalculiX's order
    across: tuple[float, float, float]  # second laminate axis; the first is x
    angles_deg: list[float]  # bottom to top


@dataclass
class Model:
    """A cantilever of shell elements along x, clamped at x = 0."""

    points: Array  # (n, 3) [m]
    walls: list[Wall]
    material: dict[str, Any]
    ply: float  # thickness [m]
    kind: str  # "S8R" or "S6"
    loads: dict[str, dict[int, Array]]  # case -> point -> force (3,) [N]
    probes: dict[str, dict[int, Array]]  # case -> point -> weights (3,) of the number asked for


class Answer(NamedTuple):
    """What a run gave."""

    frequencies: Array  # (m,) [Hz]
    displacements: dict[str, Array]  # case -> (n, 3) [m]
    seconds: float  # of processor
    nodes: int  # of the shell mesh


def grid(model_points: dict[tuple[float, ...], int], corners: Any, kind: str) -> list[list[int]]:
    """Quadratic elements on a rectangular grid of places (i, j, 3), half steps included."""
    number = np.array(
        [
            [model_points.setdefault(tuple(np.round(p, 9)), len(model_points)) for p in row]
            for row in corners
        ]
    )
    elements = []
    for i in range(0, len(number) - 2, 2):
        for j in range(0, len(number[0]) - 2, 2):
            a = number[i : i + 3, j : j + 3]
            if kind == "S8R":
                ring = [a[0, 0], a[2, 0], a[2, 2], a[0, 2], a[1, 0], a[2, 1], a[1, 2], a[0, 1]]
                elements.append([int(n) for n in ring])
            elif (i + j) % 4 == 0:  # alternating diagonals
                lower = [a[0, 0], a[2, 0], a[2, 2], a[1, 0], a[2, 1], a[1, 1]]
                upper = [a[0, 0], a[2, 2], a[0, 2], a[1, 1], a[1, 2], a[0, 1]]
                elements += [[int(n) for n in lower], [int(n) for n in upper]]
            else:
                lower = [a[0, 0], a[2, 0], a[0, 2], a[1, 0], a[1, 1], a[0, 1]]
                upper = [a[2, 0], a[2, 2], a[0, 2], a[2, 1], a[1, 2], a[1, 1]]
                elements += [[int(n) for n in lower], [int(n) for n in upper]]
    return elements


def box(layup: str, n: tuple[int, int, int], kind: str = "S8R") -> Model:
    """The box beam; n counts elements along it, across the wide and across the high walls."""
    half = np.array([0.5 * (WIDTH - WALL), 0.5 * (HEIGHT - WALL)])
    ring = np.array([[-1, 1], [1, 1], [1, -1], [-1, -1], [-1, 1]]) * half
    names = ("top", "right", "bottom", "left")
    along = np.linspace(0.0, LENGTH, 2 * n[0] + 1)
    index: dict[tuple[float, ...], int] = {}
    walls, rim = [], []
    for (name, (a, b)), cells in zip(
        zip(names, pairwise(ring), strict=True), (n[1], n[2], n[1], n[2]), strict=True
    ):
        across = np.linspace(0.0, 1.0, 2 * cells + 1)[:, None]
        side = (1.0 - across) * a + across * b
        places = [[(x, *yz) for yz in side] for x in along]
        elements = grid(index, places, kind)
        direction = (b - a) / np.linalg.norm(b - a)
        walls.append(Wall(elements, (0.0, *map(float, direction)), list(BOXES[layup][name])))
        rim.append((side, float(np.linalg.norm(b - a)), direction))
    loads = _rim_loads(index, rim)
    return Model(np.array(list(index)), walls, BOX_MATERIAL, WALL / 6.0, kind, loads, loads)


def simpson(cells: int) -> Array:
    """Weights of the nodes of quadratic edges of length 1, an even load's consistent forces."""
    weight = np.zeros(2 * cells + 1)
    for k in range(cells):
        weight[2 * k : 2 * k + 3] += np.array([1.0, 4.0, 1.0]) / 6.0
    return weight


def _rim_loads(index: dict[tuple[float, ...], int], rim: Any) -> dict[str, dict[int, Array]]:
    """Unit Fz, unit Fy (both even along the rim) and unit torque (even shear flow)."""
    loads: dict[str, dict[int, Array]] = {"Fz": {}, "Fy": {}, "T": {}}
    perimeter = sum(length for _, length, _ in rim)
    area = rim[0][1] * rim[1][1]
    for side, length, direction in rim:
        cells = (len(side) - 1) // 2
        weight = simpson(cells) * length / cells
        # from top left clockwise seen from the tip: a turn against x
        flow = -np.array([0.0, *direction]) / (2.0 * area)
        for yz, w in zip(side, weight, strict=True):
            point = index[tuple(np.round((LENGTH, *yz), 9))]
            for case, force in (
                ("Fz", np.array([0.0, 0.0, w / perimeter])),
                ("Fy", np.array([0.0, w / perimeter, 0.0])),
                ("T", flow * w),
            ):
                loads[case][point] = loads[case].get(point, np.zeros(3)) + force
    return loads


def plate(layup: str, n: tuple[int, int], kind: str = "S8R") -> Model:
    """The cantilever plate in z = 0; n counts elements along and across it."""
    along = np.linspace(0.0, PLATE_LENGTH, 2 * n[0] + 1)
    across = np.linspace(-0.5 * PLATE_WIDTH, 0.5 * PLATE_WIDTH, 2 * n[1] + 1)
    index: dict[tuple[float, ...], int] = {}
    elements = grid(index, [[(x, y, 0.0) for y in across] for x in along], kind)
    tip = index[(round(PLATE_LENGTH, 9), 0.0, 0.0)]
    wall = Wall(elements, (0.0, 1.0, 0.0), list(PLATES[layup]))
    z = np.array([0.0, 0.0, 1.0])
    edge = [index[tuple(np.round((PLATE_LENGTH, y, 0.0), 9))] for y in across]
    load = {point: w * z for point, w in zip(edge, simpson(n[1]) / n[1], strict=True)}
    probes = {"Fz": {tip: z}}
    points = np.array(list(index))
    return Model(points, [wall], PLATE_MATERIAL, PLATE_PLY, kind, {"Fz": load}, probes)


def deck(model: Model, n_mode: int, statics: bool, merged: bool = False) -> str:
    """The input file. `merged`: neighbouring plies of one angle become one layer."""
    lines = ["*NODE, NSET=ALL"]
    lines += [f"{i + 1}, {x:.12g}, {y:.12g}, {z:.12g}" for i, (x, y, z) in enumerate(model.points)]
    first = 1
    for w, wall in enumerate(model.walls):
        lines.append(f"*ELEMENT, TYPE={model.kind}, ELSET=W{w}")
        for element in wall.elements:
            lines.append(f"{first}, " + ", ".join(str(n + 1) for n in element))
            first += 1
    lines += _materials(model)
    for w, wall in enumerate(model.walls):
        stack = [(angle, model.ply) for angle in wall.angles_deg]
        if merged:
            stack = _merged(stack)
        for angle in sorted({angle for angle, _ in stack}):
            c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
            a = np.array([c, 0, 0]) + s * np.array(wall.across)
            b = np.array([-s, 0, 0]) + c * np.array(wall.across)
            lines.append(f"*ORIENTATION, NAME=O{w}A{_angle_name(angle)}, SYSTEM=RECTANGULAR")
            lines.append(", ".join(f"{v:.12g}" for v in (*a, *b)))
        lines.append(f"*SHELL SECTION, COMPOSITE, ELSET=W{w}")
        lines += [f"{t:.9g}, , PLY, O{w}A{_angle_name(angle)}" for angle, t in stack]
    clamped = np.flatnonzero(model.points[:, 0] < 1e-9) + 1
    lines += ["*BOUNDARY", *[f"{n}, 1, 6" for n in clamped]]
    if n_mode:
        lines += ["*STEP", "*FREQUENCY", str(n_mode), "*END STEP"]
    if statics:
        for case in model.loads.values():
            lines += ["*STEP", "*STATIC", "*CLOAD, OP=NEW"]
            for n, force in case.items():
                lines += [f"{n + 1}, {d + 1}, {f:.12g}" for d, f in enumerate(force) if f]
            lines += ["*NODE PRINT, NSET=ALL", "U", "*END STEP"]
    return "\n".join(lines) + "\n"


def _merged(stack: list[tuple[float, float]]) -> list[tuple[float, float]]:
    found: list[tuple[float, float]] = []
    for angle, t in stack:
        if found and found[-1][0] == angle:
            found[-1] = (angle, found[-1][1] + t)
        else:
            found.append((angle, t))
    return found


def _angle_name(angle: float) -> str:
    return f"{angle:g}".replace("-", "M").replace(".", "P")


def _materials(model: Model) -> list[str]:
    m = model.material
    names = ("E1", "E2", "E3", "nu12", "nu13", "nu23", "G12", "G13", "G23")
    constants = [m[name] for name in names]
    head = ", ".join(f"{v:.9g}" for v in constants[:8])
    return [
        "*MATERIAL, NAME=PLY",
        "*ELASTIC, TYPE=ENGINEERING CONSTANTS",
        head + ",",
        f"{constants[8]:.9g}",
        "*DENSITY",
        f"{m['rho']:.9g}",
    ]


def run(model: Model, n_mode: int = 8, statics: bool = True, merged: bool = False) -> Answer:
    """Run ccx on a model in a folder of its own."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "model.inp").write_text(deck(model, n_mode, statics, merged))
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(
            ["ccx", "model"],
            cwd=folder,
            capture_output=True,
            text=True,
            env={"PATH": "/usr/bin:/bin", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if "Job finished" not in done.stdout:
            raise RuntimeError(f"ccx failed: {done.stdout[-2000:]}")
        seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        frequencies = _frequencies(Path(folder, "model.dat")) if n_mode else np.zeros(0)
        found = _displacements(Path(folder, "model.dat"), len(model.points)) if statics else []
    fields = dict(zip(model.loads, found, strict=False))
    used = {n for wall in model.walls for element in wall.elements for n in element}
    return Answer(frequencies, fields, seconds, len(used))


def _frequencies(path: Path) -> Array:
    """The fourth column of the table of eigenvalues: cycles per time."""
    found = []
    lines = path.read_text().splitlines()
    begin = next(i for i, line in enumerate(lines) if "E I G E N V A L U E   O U T P U T" in line)
    for line in lines[begin + 1 :]:
        words = line.split()
        if len(words) == 5 and words[0].isdigit():
            found.append(float(words[3]))
        elif found and "P A R T I C I P A T I O N" in line:
            break
    return np.array(found)


def _displacements(path: Path, n_point: int) -> list[Array]:
    """Every table of displacements of a .dat file as (n_point, 3)."""
    found: list[Array] = []
    for line in path.read_text().splitlines():
        words = line.split()
        if "displacements (vx,vy,vz)" in line:
            found.append(np.full((n_point, 3), np.nan))
        elif found and len(words) == 4 and words[0].isdigit():
            found[-1][int(words[0]) - 1] = [float(word) for word in words[1:]]
    return found


def tip_numbers(model: Model, answer: Answer) -> list[float]:
    """w per Fz, v per Fy and twist per torque (work of the unit load); of a plate w at the tip."""
    return [
        float(sum(weight @ answer.displacements[case][n] for n, weight in weights.items()))
        for case, weights in model.probes.items()
    ]


def reference(name: str) -> list[float]:
    """Values of an entry of the reference file."""
    entries = tomllib.loads(REFERENCE.read_text(encoding="utf-8"))["benchmark"]
    return next(entry["value"] for entry in entries if entry["id"] == name)


def compare(name: str, model: Model) -> dict[str, Any]:
    """Run a model and print its numbers beside the stored ones."""
    answer = run(model)
    numbers = [*answer.frequencies[:6], *tip_numbers(model, answer)]
    stored = reference(name)
    print(f"{name}: {answer.nodes} nodes, {answer.seconds:.1f} s")
    for a, b in zip(numbers, stored, strict=True):
        print(f"  {a:12.6g} {b:12.6g} {100.0 * (a / b - 1.0):+7.2f} %")
    return {"id": name, "numbers": numbers, "stored": stored, "seconds": answer.seconds}


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--write", type=Path)
    parser.add_argument("--box", type=int, nargs=3, default=(40, 4, 3))
    parser.add_argument("--plate", type=int, nargs=2, default=(24, 6))
    options = parser.parse_args()
    if shutil.which("ccx") is None:
        print(ABSENT)
        sys.exit(0)
    found = [compare(f"ccx_plate_{name}", plate(name, tuple(options.plate))) for name in PLATES]
    found += [compare(f"ccx_box_{name}", box(name, tuple(options.box))) for name in BOXES]
    if options.write:
        options.write.parent.mkdir(parents=True, exist_ok=True)
        options.write.write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
