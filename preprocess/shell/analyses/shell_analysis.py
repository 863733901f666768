"""Analysis of a shell: load cases, modes and all other results from its specification."""

import dataclasses
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from ....solver.package.common.plausible import described_doubts, not_allowed, shell_doubts
from ....solver.package.shell.shell_schema import (
    ShellFile,
    ShellLaminate,
    ShellLinks,
    ShellMeshData,
    ShellPlaces,
)
from ... import fenicsx
from ...laminate.report import report
from ...laminate.stiffness import computed, stress_operators
from ..model.regions import cell_axes
from ..model.shell_problem import ShellProblem
from ..model.shell_warnings import Progress, Warnings
from ..shell_cells import ShellMesh
from .bound import bound
from .buckling import Stressed
from .cases import load_cases
from .discretisation import FinerMesh
from .modes import case_errors, shell_buckling, shell_modes


def analyse(
    spec: Mapping[str, Any],
    where: str | None = None,
    *,
    mesh: ShellMesh | None = None,
    verify: bool = False,
    team: fenicsx.Team = fenicsx.ALONE,
    progress: Progress | None = None,
) -> ShellFile:
    """Displacements, resultants, reactions and natural modes of a shell.

    Parameters
    ----------
    spec : plain data, see shell_problem.py
    where : file and key of the specification for messages, the shell's name by default
    mesh : replaces the mesh that the specification names
    verify : compute strain energies and frequencies by a second method (shell_verification)
    team : processes that all call this with the same arguments and share the matrices; each gets
        the whole result
    progress : called with one line at the beginning of each step

    Raises
    ------
    ShellError, LaminateError, MaterialError : the description is wrong (key, value, expectation),
    or
        the shell cannot be solved.
    """
    start = time.perf_counter()
    where = where or f"shell {spec.get('name', '')}".strip()
    begin = progress or (lambda _line: None)
    begin("mesh")
    problem = ShellProblem(spec, where, team, mesh)
    laminates, warnings = _laminates(problem)
    mass = sum(float(r.geometry.area.sum()) * r.stiffness.mass[0] for r in problem.regions)
    doubts = [*described_doubts(spec), *shell_doubts(spec, problem.mesh.points_G, mass)]
    units = [doubt.warning for doubt in not_allowed(spec, doubts)]
    warnings = [*problem.warnings, *warnings, *units]
    cases, probes, u = load_cases(problem, warnings, begin)
    stressed = Stressed(problem, cases.names, u)
    finer = FinerMesh(problem, begin)
    modes, left_out = shell_modes(stressed, finer, warnings, begin)
    buckling = shell_buckling(stressed, finer, warnings, begin)
    error = case_errors(problem, cases, finer, verify, warnings)
    bounded = None if spec.get("bound") is None else bound(stressed, spec["bound"], begin)
    cases = dataclasses.replace(cases, error=error)
    second = None
    if verify:
        from .shell_verification import (
            verified,  # here: its forms are loaded only where they are needed
        )

        begin("verification")
        second = verified(problem, finer, cases, modes, warnings)
        warnings += second.warnings
    return ShellFile(
        name=str(spec.get("name", "shell")),
        mesh=_mesh_data(problem),
        laminates=tuple(laminates),
        materials={name: dict(table) for name, table in spec["materials"].items()},
        supports=ShellPlaces(
            tuple(support.name for support in problem.supports),
            np.array([support.point_G for support in problem.supports]).reshape(-1, 3),
        ),
        links=ShellLinks(
            tuple(link.name for link in problem.links),
            np.array([link.point_G for link in problem.links]).reshape(-1, 3),
            tuple(link.kind for link in problem.links),
        ),
        cases=cases,
        probes=probes,
        modes=modes,
        buckling=buckling,
        warnings=tuple(warnings),
        provenance={
            "spec": dict(spec),
            "elements": {**problem.choice._asdict(), "mass_form": problem.mass_form},
            "dofs": problem.freedom.n_dof,
            "frequency_errors": left_out or None,
            "bound": bounded,
            "verification": None if second is None else second.words,
            "ranks": problem.team.size,
            "seconds": time.perf_counter() - start,
            "versions": fenicsx.versions(),
        },
    )


def _laminates(problem: ShellProblem) -> tuple[list[ShellLaminate], Warnings]:
    """Each laminate that a region uses, once, with its warnings."""
    laminates, warnings = [], list[dict[str, str]]()
    for name, region in problem.laminates.items():
        laminate, stiffness = region.laminate.laminate, region.stiffness
        with computed(f"{problem.where}.laminates.{name}"):
            known = report(laminate, name, region.laminate.shear)
            operators = stress_operators(laminate)
        warnings += known.findings
        table = dataclasses.asdict(known)
        del table["findings"]
        table["offset"] = laminate.offset
        plies, mass = region.laminate.plies, stiffness.mass
        laminates.append(
            ShellLaminate(name, plies, stiffness.ABD, stiffness.Ds, mass, operators, table)
        )
    return laminates, warnings


def _mesh_data(problem: ShellProblem) -> ShellMeshData:
    mesh, laminates = problem.mesh, list(problem.laminates)
    of_region = {region.name: region.laminate_name for region in problem.regions}
    area = np.empty(len(mesh.cells))
    for region in problem.regions:
        area[region.cells] = region.geometry.area
    return ShellMeshData(
        nodes_G=mesh.points_G,
        node_ids=mesh.node_tags,
        cells=mesh.cells,
        region=mesh.region,
        regions=mesh.regions,
        laminate=np.array([laminates.index(of_region[name]) for name in mesh.regions]),
        A_GE=cell_axes(mesh, problem.regions),
        area=area,
    )
