"""Derivatives of sections by parameters, compared with quotients of fresh analyses."""

from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.section.analysis import analyse
from plymotion.preprocess.section.derivatives import (
    PrismaticSolver,
    central,
    changed,
    stiffness_terms,
)
from plymotion.preprocess.section.parameters import parameters
from plymotion.preprocess.section.problem import section_problem, solve
from plymotion.preprocess.section.space.layers import layup
from plymotion.preprocess.section.spec import SectionError
from plymotion.preprocess.section.timoshenko import scaled
from plymotion.solver.inputs.section.shapes.library import expand, walls
from plymotion.solver.package.common.dataset import all_values
from plymotion.solver.package.section.schema import SectionFile

PLY = {
    "kind": "orthotropic",
    **{"E1": 142e9, "E2": 9.8e9, "E3": 9.8e9, "G12": 6e9, "G13": 5e9, "G23": 3.5e9},
    **{"nu12": 0.3, "nu13": 0.3, "nu23": 0.4, "rho": 1600.0},
}
Design = dict[str, list[dict[str, Any]]]
Numbers = dict[str, Any]


def of(*paths: str, factor: float = 1.0) -> list[dict[str, Any]]:
    """A parameter of these targets."""
    return [{"of": path, "factor": factor} for path in paths]


def described(
    shape: str, sizes: dict[str, Any], plies: dict[str, list[tuple[float, float]]], **more: Any
) -> dict[str, Any]:
    """A section of a shape with the plies (angle [deg], thickness [m]) of each of its walls."""
    stacks = {
        wall.region: [
            {"material": "ply", "angle_deg": angle, "thickness": t}
            for angle, t in plies.get(wall.region, plies["all"])
        ]
        for wall in walls(shape, sizes)
    }
    layers = {name: [ply["thickness"] for ply in stack] for name, stack in stacks.items()}
    return {
        "name": shape,
        "convention": "contour",
        "mesh": expand(shape, sizes, layers),
        "materials": {"ply": PLY},
        "regions": {
            wall.region: {"plies": stacks[wall.region], "direction": wall.direction}
            for wall in walls(shape, sizes)
        },
        **more,
    }


def box(wall: float = 6e-4, **more: Any) -> dict[str, Any]:
    angles = {"all": (20.0, -35.0, 60.0), "top": (0.0, 15.0, 70.0), "left": (45.0, 10.0, -80.0)}
    plies = {name: [(angle, wall / 3) for angle in some] for name, some in angles.items()}
    return described("box", {"width": 0.024, "height": 0.014, "wall": wall}, plies, **more)


ANGLES = {
    f"{wall}-{i}": of(f"regions.{wall}.plies.{i}.angle_deg")
    for wall in ("top", "right", "bottom", "left")
    for i in range(3)
}


def numbers(section: SectionFile) -> Numbers:
    found = {path: np.asarray(value) for path, value in all_values(section).items()}
    return {path: value for path, value in found.items() if value.dtype.kind == "f"}


def quotients(spec: dict[str, Any], design: Design, steps: float, **how: Any) -> list[Numbers]:
    """Derivatives by Richardson's extrapolation of central differences, of sixth order."""
    found = []
    for parameter in parameters(spec, design, "section"):
        h = steps * parameter.step
        at = {
            i: numbers(analyse(parameter.moved(i * h), estimate=False, **how))
            for i in (-3, -2, -1, 1, 2, 3)
        }
        found.append(
            {
                path: (
                    45.0 * (at[1][path] - at[-1][path])
                    - 9.0 * (at[2][path] - at[-2][path])
                    + (at[3][path] - at[-3][path])
                )
                / (60.0 * h)
                for path in at[1]
            }
        )
    return found


def largest(section: SectionFile, expected: list[Numbers]) -> float:
    """Largest difference of K', in units of sqrt(K_ii K_jj) per change by its own size."""
    return max(
        float(scaled(one.values["K"] - other["K"], section.K).max())
        / max(1.0, float(scaled(other["K"], section.K).max()))
        for one, other in zip(section.design, expected, strict=True)
    )


PRISMATIC = box()


def test_twelve_angles() -> None:
    section = analyse(PRISMATIC, estimate=False, design=ANGLES)
    expected = quotients(PRISMATIC, ANGLES, 10.0)
    assert largest(section, expected) < 1e-8
    for one, other in zip(section.design, expected, strict=True):
        assert one.kind == "angle"
        assert "M" not in one.values
        strain, rate = one.values["recovery/strain_M"], other["recovery/strain_M"]
        assert np.all(np.abs(strain - rate).max(axis=0) < 1e-6 * np.abs(rate).max(axis=0))
        turned, rate = one.values["recovery/A_BM"], other["recovery/A_BM"]
        assert np.abs(turned - rate).max() < 1e-12


def test_stiffness_is_homogeneous() -> None:
    """With dC = C, Euler's theorem gives dS = -S, so that dK = K."""
    problem = section_problem(PRISMATIC["mesh"], "section", 2)
    lay = layup(PRISMATIC, problem.mesh, problem.space, "section")
    result = solve(problem, lay, "section", PRISMATIC, measured=False)
    factorised = problem.factorised(result, lay.stiffness)
    assert factorised is not None
    state = central(result, lay.stiffness)
    terms = stiffness_terms(state, np.arange(problem.space.n_cell), lay.stiffness)
    change = changed(state, PrismaticSolver(result, state, factorised), terms)
    assert scaled(change.K - result.K, result.K).max() < 1e-10


@pytest.mark.parametrize(
    ("design", "message"),
    [
        (of("regions.top.plies.9.angle_deg"), "no such key '9'; expected 0, 1, 2"),
        (of("regions.top.plies.0.material"), "a section has no derivative by it"),
        (of("materials.ply.strength.Xt"), "a section has no derivative by it"),
        (of("initial_curvature.0"), "a section has no derivative by it"),
        (of("mesh.parameters.elements_2"), "expected a length, not a number of cells"),
        (of("regions.top.plies.0.thickness"), "the mesh does not follow"),
    ],
)
def test_refused(design: list[dict[str, Any]], message: str) -> None:
    with pytest.raises(SectionError, match=message):
        analyse(PRISMATIC, estimate=False, design={"a": design})
