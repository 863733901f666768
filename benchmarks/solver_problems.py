"""Mechanisms of the solver's benchmarks as run files, with the point whose error is measured."""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from solver_methods import PEERS, Method

from plymotion.solver.inputs.case.load import load_case, merge
from plymotion.solver.inputs.case.record import seal
from plymotion.solver.inputs.case.tables.schema import resolved
from plymotion.solver.inputs.case.write import dump, write_if_changed
from plymotion.solver.math.arrays import Array
from plymotion.solver.package import Interface, ModalPackage, read_package
from plymotion.solver.results import RunResult
from plymotion.solver.run.execution import read_run
from plymotion.solver.run.inputs import RunSpec

SHIPPED = Path("tests/packages")
EIGHT = SHIPPED / "double-pendulum-8"  # 8 elements a link, lumped, 4 + 4 modes
GRAVITY = (0.0, -9.81, 0.0)
RUNS = Path("build/benchmarks/runs")
SEEN = 0.01  # [s]; errors are the largest at multiples of it
# Keys of `[solver]` that belong to the mechanism, not to the method.
KEPT = ("output_step", "start", "modes_at_start", "on_invalid", "on_singular")


@dataclass(frozen=True)
class Problem:
    """A run of a mechanism, and where its error is measured."""

    name: str
    title: str
    file: Path  # run file
    spec: RunSpec
    packages: Mapping[str, Path]
    probe: tuple[str, str]  # body, interface

    @property
    def t_end(self) -> float:
        """End of the motion [s]."""
        return self.spec.mechanism.solver.t_end

    def with_solver(self, method: Method, rtol: float, **changes: Any) -> RunSpec:
        """The run by a method: `[solver]` has its keys, rtol and the times, else defaults."""
        keys = self.solver(method, rtol) | changes
        if method.integrator not in PEERS:
            return self.spec.changed({"solver": keys})
        # a case cannot name it: checked as that of one of ours
        ours = "generalized-alpha" if keys["constraints"] == "ggl" else "rk8"
        spec = self.spec.changed({"solver": keys | {"integrator": ours}})
        solver = spec.mechanism.solver.model_copy(update={"integrator": method.integrator})
        mechanism = spec.mechanism.model_copy(update={"solver": solver})
        return replace(spec, mechanism=mechanism)

    def solver(self, method: Method, rtol: float) -> dict[str, Any]:
        """`[solver]` of a case for a method."""
        found: dict[str, Any] = {
            **_kept(self.spec.mechanism.model_dump()["solver"]),
            "t_end": self.t_end,
            "integrator": method.integrator,
            "rtol": rtol,
        }
        return found | {"constraints": method.constraints} | method.options

    def written(self, name: str, solver: Mapping[str, Any]) -> Path:
        """Run file of the same mechanism with another `[solver]`, for `plymotion run`."""
        table = self.spec.mechanism.model_dump() | {"solver": dict(solver)}
        return write_run(name, table, self.packages)

    def places(self, result: RunResult) -> Array:
        """Global positions (k, 3) of the probe every SEEN seconds [m]."""
        name, place = self.probe
        first = 0
        for body in result.bodies:
            if body.name == name:
                break
            first += len(body.nodes_B)
        k = first + node(self.spec.packages[name], place)
        rate = result.t / SEEN
        seen = np.abs(rate - np.round(rate)) < 1e-6
        return np.asarray(result.node_positions_G[seen, k])


def _kept(solver: Mapping[str, Any]) -> dict[str, Any]:
    return {key: solver[key] for key in KEPT}


def interface(package: ModalPackage, name: str) -> Interface:
    """Interface of a package by its name."""
    return next(i for i in package.interfaces if i.name == name)


def node(package: ModalPackage, name: str) -> int:
    """Row of the node at an interface."""
    away = np.linalg.norm(package.nodes_B - interface(package, name).position_B, axis=1)
    return int(np.argmin(away))


def plain(table: Mapping[str, Any]) -> Any:
    """Return a table as a file holds it: lists for tuples."""
    return json.loads(json.dumps(table))


def write_run(
    name: str, table: Mapping[str, Any], packages: Mapping[str, Path], runs: Path = RUNS
) -> Path:
    """Write a run file as `plymotion check` does, for packages that exist."""
    mechanism = resolved(plain(table), name)
    file = runs / name / "runs" / f"{Path(name).name}.json"
    entries = {
        body: {"file": os.path.relpath(path, file.parent.parent)} for body, path in packages.items()
    }
    content = {"case": name, "run": name, "title": name, "packages": entries}
    checked = {"checked": seal(mechanism), "mechanism": mechanism.model_dump()}
    write_if_changed(file, dump(content | checked))
    return file


def from_case(
    case: Path,
    run: str,
    packages: Mapping[str, Path],
    probe: tuple[str, str],
    t_end: float,
    *,
    name: str = "",
    title: str = "",
    changes: Mapping[str, Any] | None = None,
) -> Problem:
    """Run of a case with the given packages; of `[solver]` only KEPT and t_end are given."""
    table = load_case(case).runs[run].model_dump()
    table["solver"] = _kept(table["solver"]) | {"t_end": t_end}
    merge(table, dict(changes or {}))
    name = name or case.parent.name
    file = write_run(name, table, packages)
    return Problem(name, title, file, read_run(file), packages, probe)


def double_pendulum(
    folder: Path = EIGHT, *, gravity: float = 9.81, t_end: float = 1.0, name: str = ""
) -> Problem:
    """Run `isotropic` of the double pendulum."""
    return from_case(
        Path("cases/double-pendulum/case.toml"),
        "isotropic",
        {body: folder / f"{body}.vtkhdf" for body in ("arm", "hand")},
        ("hand", "tip"),
        t_end,
        name=name,
        title=f"double pendulum, 8 elements a link, 4 + 4 modes, {t_end:g} s",
        changes={"gravity": [0.0, -gravity, 0.0]},
    )


def actuated_beam(file: Path = SHIPPED / "actuated-beam" / "beam.layup-1.vtkhdf") -> Problem:
    """Lay-up 1 of the actuated beam, half a turn of its crank."""
    return from_case(
        Path("cases/actuated-beam/case.toml"),
        "layup-1",
        {"beam": file},
        ("beam", "tip"),
        1.0,
        title="actuated beam, lay-up 1, 16 elements, 7 modes, 1 s",
    )


def chain(n: int, t_end: float = 1.0, file: Path = EIGHT / "hand.vtkhdf") -> Problem:
    """Chain of n flexible links, released at rest from the horizontal; probe at its end.

    Every link is the hand of the double pendulum without its mass.
    """
    package = read_package(file)
    length = float(interface(package, "tip").position_B[0])
    bodies, joints = {}, {}
    for i in range(n):
        bodies[f"link-{i}"] = {
            "kind": "package",
            "package": file.name,
            "position": [i * length, 0.0, 0.0],
        }
        before = f"link-{i - 1}.tip" if i else "ground.hinge"
        joints[f"hinge-{i}"] = {
            "kind": "revolute",
            "between": [before, f"link-{i}.root"],
            "axis": [0.0, 0.0, 1.0],
        }
    end = f"link-{n - 1}"
    table = {
        "gravity": GRAVITY,
        "bodies": bodies,
        "ground": {"hinge": {"position": [0.0, 0.0, 0.0]}},
        "joints": joints,
        "signals": {"tip_y": {"kind": "position", "at": f"{end}.tip", "component": "y"}},
        "solver": {"t_end": t_end, "output_step": min(SEEN, t_end)},
    }
    name = f"chain-{n}"
    files = dict.fromkeys(bodies, file)
    written = write_run(name, table, files)
    title = f"chain of {n} links, {package.n_mode} modes each, {t_end:g} s"
    # one package object for all links: read_run would read the same file n times
    spec = RunSpec(name, name, resolved(plain(table), name), dict.fromkeys(bodies, package))
    return Problem(name, title, written, spec, files, (end, "tip"))
