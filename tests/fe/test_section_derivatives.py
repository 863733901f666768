"""Derivatives of sections by parameters, compared with quotients of fresh analyses."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.section.derivatives import (
    PrismaticSolver,
    central,
    changed,
)
from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.section_parameters import STEP, parameters
from plymotion.preprocess.section.section_problem import section_problem, solve
from plymotion.preprocess.section.section_specification import SectionError
from plymotion.preprocess.section.space.layers import layup
from plymotion.preprocess.section.timoshenko import scaled
from plymotion.solver.inputs.section.shapes.library import expand, walls
from plymotion.solver.package.common.dataset import all_values
from plymotion.solver.package.common.design import moved
from plymotion.solver.package.common.materials import PlyStrength
from plymotion.solver.package.section.section_schema import SectionFile
from plymotion.solver.strength import criteria_of
from plymotion.solver.strength.weakest_plies import unit_stress_M

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
    sizes = {"width": 0.024, "height": 0.014, "wall": wall, "density": 0.3}
    return described("box", sizes, plies, **more)


ANGLES = {
    f"{wall}-{i}": of(f"regions.{wall}.plies.{i}.angle_deg")
    for wall in ("top", "right", "bottom", "left")
    for i in range(3)
}


def numbers(section: SectionFile) -> Numbers:
    found = {path: np.asarray(value) for path, value in all_values(section).items()}
    return {path: value for path, value in found.items() if value.dtype.kind == "f"}


def richardson(at: dict[int, Any], h: float) -> Any:
    """Extrapolation of central differences, of sixth order."""
    one, two, three = (at[i] - at[-i] for i in (1, 2, 3))
    return (45.0 * one - 9.0 * two + three) / (60.0 * h)


PLACES = (-3, -2, -1, 1, 2, 3)


def quotients(
    spec: dict[str, Any], design: Design, steps: float, like: dict[str, Any] | None = None
) -> list[Numbers]:
    """Derivatives of all numbers, of fresh analyses of one discretisation."""
    found = []
    for parameter in parameters(spec, design, "section"):
        h = steps * parameter.step
        at = {
            i: numbers(analyse(parameter.moved(i * h), estimate=False, discretisation=like))
            for i in PLACES
        }
        found.append({path: richardson({i: at[i][path] for i in at}, h) for path in at[1]})
        found[-1]["size"] = 1.0 if parameter.kind == "angle" else parameter.step / STEP
    return found


def differences(section: SectionFile, expected: list[Numbers]) -> Numbers:
    """Largest difference of K', M' and of the recovery.

    K and M in units of sqrt(K_ii K_jj) per degree, or per relative change of other numbers; the
    recovery in units of the largest rate, strains by resultant.
    """
    found: Numbers = {}
    for one, other in zip(section.design, expected, strict=True):
        for path, whole in (("K", section.K), ("M", section.M)):
            rate = other[path]
            own = one.values.get(path, np.zeros((6, 6)))
            off = other["size"] * scaled(own - rate, whole).max()
            found[path] = max(found.get(path, 0.0), off)
        for path in ("recovery/strain_M", "recovery/A_BM", "recovery/points", "recovery/weights"):
            rate = other[path]
            own = one.values.get(path, np.zeros(rate.shape))
            parts = (0, 1) if path.endswith("strain_M") else None
            size = np.maximum(np.abs(rate).max(axis=parts), 1e-12)
            off = np.max(np.abs(own - rate).max(axis=parts) / size)
            found[path] = max(found.get(path, 0.0), float(off))
    return found


PRISMATIC = box()


@pytest.mark.one_end
def test_twelve_angles() -> None:
    """Also ply axes, and nothing that does not change."""
    section = analyse(PRISMATIC, estimate=False, design=ANGLES)
    found = differences(section, quotients(PRISMATIC, ANGLES, 10.0))
    assert found["K"] < 1e-8
    assert found["recovery/strain_M"] < 1e-6
    assert found["recovery/A_BM"] < 1e-9
    assert all(one.kind == "angle" and "M" not in one.values for one in section.design)
    alone = analyse(PRISMATIC, estimate=False, design=ANGLES, design_strains=False)
    for one, other in zip(section.design, alone.design, strict=True):
        assert scaled(one.values["K"] - other.values["K"], section.K).max() < 1e-12


def station() -> dict[str, Any]:
    """A blade's section of three cells with caps and two webs."""
    sizes = {"contour": "naca4415", "chord": 0.3, "skin": 8e-4, "cap": 1.6e-3, "web": 1e-3}
    sizes |= {"webs": [0.2, 0.45], "density": 0.25}
    plies = {"all": [(45.0, 4e-4), (-45.0, 4e-4)], "web-1": [(45.0, 1e-3)], "web-2": [(30.0, 1e-3)]}
    caps = [(45.0, 4e-4), (0.0, 8e-4), (10.0, 4e-4)]
    return described("airfoil", sizes, plies | {"cap-upper": caps, "cap-lower": caps})


CAP = of(*(f"regions.cap-{side}.plies.1.angle_deg" for side in ("upper", "lower")))
OTHERS: dict[str, tuple[dict[str, Any], Design, float]] = {
    "walls of t/w = 1e-4": (box(2.4e-6), {"top-1": ANGLES["top-1"]}, 30.0),
    "twisted and curved": (
        box(initial_curvature=[3.0, 1.0, -2.0]),
        {"left-2": ANGLES["left-2"], "nu": of("materials.ply.nu12")},
        10.0,
    ),
    "station of a blade": (
        station(),
        {"cap": CAP, "web": of("regions.web-1.plies.0.angle_deg")},
        10.0,
    ),
    "constants": (
        PRISMATIC,
        {key: of(f"materials.ply.{key}") for key in ("E1", "nu23", "rho")},
        10.0,
    ),
}


@pytest.mark.one_end
@pytest.mark.parametrize("name", OTHERS)
def test_other_sections(name: str) -> None:
    spec, design, steps = OTHERS[name]
    found = differences(
        analyse(spec, estimate=False, design=design), quotients(spec, design, steps)
    )
    assert found["K"] < 1e-8
    assert found["M"] < 1e-9
    assert found["recovery/strain_M"] < 1e-6


@pytest.mark.one_end
def test_sizes_and_thicknesses() -> None:
    """The mesh follows: a wall, a width of a twisted box, the radius of a tube of turning plies.

    The fresh meshes are those of gmsh, whose nodes have an error of 1e-8 of their curve.
    """
    sizes = {"width": 0.024, "height": 0.014, "wall": 6e-4, "density": 0.25}
    flat = described("box", sizes, {"all": [(25.0, 6e-4)]})
    twisted = {**flat, "initial_curvature": [3.0, 1.0, -2.0]}
    ring = described("tube", {"outer_radius": 0.02, "wall": 2e-3}, {"all": [(20.0, 1e-3)] * 2})
    wall = of("mesh.parameters.wall_top", "regions.top.plies.0.thickness")
    for spec, design in (
        (flat, wall),
        (twisted, of("mesh.parameters.width")),
        (ring, of("mesh.parameters.outer_radius")),
    ):
        section = analyse(spec, estimate=False, design={"size": design})
        found = differences(section, quotients(spec, {"size": design}, 20.0))
        assert found["K"] < 1e-8
        assert found["M"] < 1e-9
        assert found["recovery/strain_M"] < 1e-5
        assert found["recovery/points"] < 1e-5
        assert found["recovery/weights"] < 1e-5


def test_second_degree_quadrilaterals_and_triangles(tmp_path: Path) -> None:
    """Cells of other codes: their own functions, a layer angle at their nodes."""
    n_2, n_3 = 6, 4
    x = np.stack(np.meshgrid(np.arange(2 * n_2 + 1), np.arange(2 * n_3 + 1), indexing="ij"), -1)
    place = (x * [0.01 / 12, 0.004 / 8] - [0.005, 0.002]).reshape(-1, 2)
    place[:, 1] += 8.0 * place[:, 0] ** 2  # curved cells
    number = np.arange(len(place)).reshape(2 * n_2 + 1, 2 * n_3 + 1)
    ring = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
    cells = np.array(
        [[number[2 * i + a, 2 * j + b] for a, b in ring] for i in range(n_2) for j in range(n_3)]
    )
    corners = cells[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    upper = place[cells[:, :4]].mean(axis=1)[:, 1] > 0.0
    for kind, table, rows in (("quad8", cells, upper), ("triangle", corners, upper.repeat(2))):
        file = tmp_path / f"{kind}.npz"
        names = np.array(["lower", "upper"])
        np.savez(
            file,
            points=place,
            cells=table,
            cell_type=kind,
            region=rows.astype(int),
            region_names=names,
        )
        spec = {
            "mesh": {"arrays": str(file), **({"degree": "mesh"} if kind == "quad8" else {})},
            "materials": {"ply": PLY},
            "regions": {
                "upper": {"plies": [{"material": "ply", "angle_deg": 25.0}]},
                "lower": {"plies": [{"material": "ply", "angle_deg": -50.0}]},
            },
        }
        for region in spec["regions"].values():
            region["direction"] = {"vector": [1.0, 0.0]}
        design = {"upper": of("regions.upper.plies.0.angle_deg"), "G12": of("materials.ply.G12")}
        found = differences(
            analyse(spec, "bar", estimate=False, design=design), quotients(spec, design, 10.0)
        )
        assert found["K"] < 1e-8
        assert found["recovery/strain_M"] < 1e-6


@pytest.mark.one_end
def test_refined_mesh_of_one_discretisation() -> None:
    """Hanging nodes: neighbouring values have the divisions of cells of the first analysis."""
    sizes = {"width": 0.02, "height": 0.02, "wall": 2e-3, "density": 0.3}
    spec = described("box", sizes, {"all": [(30.0, 2e-3)]})
    design = {
        "angle": of(*(f"regions.{wall}.plies.0.angle_deg" for wall in ("top", "left"))),
        "height": of("mesh.parameters.height"),
    }
    section = analyse(spec, accuracy=2e-3, design=design)
    like = section.provenance["discretisation"]
    assert like["divided"]
    again = analyse(spec, estimate=False, discretisation=like)
    assert np.array_equal(again.K, section.K)
    found = differences(section, quotients(spec, design, 20.0, like))
    assert found["K"] < 1e-8
    assert found["recovery/strain_M"] < 1e-5


@pytest.mark.one_end
def test_strength_ratio() -> None:
    """Criteria along the rates of strains and axes: that of fresh analyses, at every point."""
    load = np.array([300.0, -40.0, 25.0, 1.5, 4.0, -6.0])
    strength = PlyStrength(1500e6, 1200e6, 40e6, 200e6, 40e6, 200e6, 70e6, 70e6, 75e6)

    def judged(section: SectionFile) -> tuple[Any, Any]:
        stress = unit_stress_M(section.recovery) @ load
        found = [one.assess(stress, strength) for one in criteria_of(strength)]
        # criteria have kinks where the mode changes, or the sign of a stress
        signs = np.broadcast_to(np.sign(stress).T, (len(found), *stress.T.shape))
        modes = np.array([one.mode for one in found])[:, None]
        return np.array([one.exposure for one in found]), np.concatenate([modes, signs], axis=1)

    design = {"top-1": ANGLES["top-1"]}
    (parameter,) = parameters(PRISMATIC, design, "section")
    section, h, small = analyse(PRISMATIC, estimate=False, design=design), 0.3, 1e-3
    at = {i: judged(analyse(parameter.moved(i * h), estimate=False)) for i in PLACES}
    smooth = np.all([at[i][1] == at[1][1] for i in PLACES], axis=(0, 2))
    assert smooth.mean() > 0.9
    expected = richardson({i: at[i][0] for i in PLACES}, h)[smooth]
    every = richardson({i: judged(moved(section, {"top-1": i * small}))[0] for i in PLACES}, small)
    own = every[smooth]
    assert np.abs(own - expected).max() < 1e-6 * np.abs(expected).max()
    # without the rate of the warping only the plies that turn would change
    others = section.recovery.ply != 1
    assert np.abs(every[:, others]).max() > 0.1 * np.abs(every).max()


@pytest.mark.one_end
def test_stiffness_is_homogeneous() -> None:
    """With dC = C, Euler's theorem gives dS = -S, so that dK = K."""
    problem = section_problem(PRISMATIC, "section", 2)
    lay = layup(PRISMATIC, problem.mesh, problem.space, "section")
    result = solve(problem, lay, "section", PRISMATIC, measured=False)
    factorised = problem.factorised(result, lay.stiffness)
    assert factorised is not None
    state = central(result, lay.stiffness)
    rates = [(np.arange(problem.space.n_cell), lay.stiffness)]
    (K,) = changed(state, PrismaticSolver(result, state, factorised), rates).K
    assert scaled(K - result.K, result.K).max() < 1e-10


@pytest.mark.one_end
@pytest.mark.parametrize(
    ("design", "message"),
    [
        (of("regions.top.plies.9.angle_deg"), "no '9' in regions.top.plies"),
        (
            of("regions.top.plies.0.material"),
            "expected a number that can be a design parameter|no '",
        ),
        (of("materials.ply.strength.Xt"), "no 'strength' in materials.ply"),
        (of("initial_curvature.0"), "no 'initial_curvature' in the specification"),
        (of("mesh.parameters.elements_2"), "expected a length, not a number of cells"),
        (of("regions.top.plies.0.thickness"), "the mesh does not follow"),
    ],
)
def test_refused(design: list[dict[str, Any]], message: str) -> None:
    with pytest.raises(SectionError, match=message):
        analyse(PRISMATIC, estimate=False, design={"a": design})
