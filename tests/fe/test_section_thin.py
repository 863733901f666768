"""Thin walls and soft layers: closed forms, round-off within the estimate, no refusal."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plymotion.preprocess.laminate.stiffness import Lamina, Laminate, laminate_stiffness
from plymotion.preprocess.section.section_analysis import analyse
from plymotion.preprocess.section.section_problem import SectionProblem
from plymotion.preprocess.section.section_specification import SectionError
from plymotion.preprocess.section.section_warnings import bulk_over_shear
from plymotion.preprocess.section.space.section_cells import turned
from plymotion.preprocess.section.space.section_mesh import section_mesh
from plymotion.preprocess.section.space.space import SectionSpace
from plymotion.preprocess.section.space.unknowns import differences_across
from plymotion.preprocess.section.timoshenko import scaled
from plymotion.solver.inputs.section.shapes.library import expand
from plymotion.solver.package.common.materials import isotropic, material_from_dict

NU = 0.3
ARC = 0.25  # elements of the open arc over the default
G = 0.5 / (1.0 + NU)


def on_one_end(*values: Any) -> list[Any]:
    """Parameters of tests whose last one runs on both ends: it needs the same calls."""
    return [*(pytest.param(value, marks=pytest.mark.one_end) for value in values[:-1]), values[-1]]


WALLS = on_one_end(1e-2, 1e-3, 1e-4, 1e-5)


def described(
    shape: str,
    sizes: dict[str, float],
    materials: dict[str, Any] | None = None,
    plies: list[dict[str, Any]] | None = None,
    **mesh: Any,
) -> dict[str, Any]:
    region = "wall" if shape == "tube" else "section"
    direction = {"circle": [0.0, 0.0]} if shape == "tube" else {"vector": [1.0, 0.0]}
    plies = plies or [{"material": "m"}]
    layers = {region: [p["thickness"] for p in plies]} if len(plies) > 1 else {}
    return {
        "name": shape,
        "mesh": {**expand(shape, sizes, layers), **mesh},
        "materials": materials or {"m": {"kind": "isotropic", "E": 1.0, "nu": NU, "rho": 1.0}},
        "regions": {region: {"plies": plies, "direction": direction}},
    }


def strip(t: float) -> Any:
    """Diagonal of K of a strip of width 1 by closed forms (shear: Renton 1991)."""
    n = np.arange(1.0, 200001.0)
    x = n * np.pi * t
    lag = np.where(x < 1e-2, x**3 / 3 - 2 * x**5 / 15, x - np.tanh(x))
    tail = 18.0 / np.pi**5 / t**5 * np.sum((lag / n**5)[::-1])
    shear_3 = 1.0 / (1.2 + (NU / (1.0 + NU)) ** 2 * tail)
    odd = np.arange(1.0, 2001.0, 2.0)
    lost = 192.0 / np.pi**5 * t * np.sum(np.tanh(odd * np.pi / 2.0 / t) / odd**5)
    J = t**3 / 3.0 * (1.0 - lost)
    shear_2 = 1.0 / (1.2 + 0.2 * (NU / (1.0 + NU)) ** 2 * t**4)
    return np.array([t, shear_2 * G * t, shear_3 * G * t, G * J, t**3 / 12.0, t / 12.0])


def tube(t: float) -> Any:
    """Diagonal of K of a tube of mean radius 1 by closed forms (shear: Renton 1991)."""
    outer, inner = 1.0 + 0.5 * t, 1.0 - 0.5 * t
    m = inner / outer
    area, bend = np.pi * (outer**2 - inner**2), 0.25 * np.pi * (outer**4 - inner**4)
    ring = (1.0 + m * m) ** 2
    k = 6 * (1 + NU) ** 2 * ring
    k /= (7 + 14 * NU + 8 * NU**2) * ring + 4 * m * m * (5 + 10 * NU + 4 * NU**2)
    return np.array([area, k * G * area, k * G * area, 2.0 * G * bend, bend, bend])


@pytest.mark.parametrize("t", WALLS)
def test_tube(t: float) -> None:
    """The rest, 4e-6, is the distance of the parabolic edges from circles."""
    found = analyse(described("tube", {"outer_radius": 1.0 + 0.5 * t, "wall": t}))
    assert np.diag(found.K) == pytest.approx(tube(t), rel=5e-6)
    assert scaled(np.asarray(found.error_estimate), found.K).max() < 1e-5
    assert found.warnings == ()


@pytest.mark.one_end
@pytest.mark.parametrize("t", WALLS)
def test_strip(t: float) -> None:
    found = analyse(described("rectangle", {"width": 1.0, "height": t}))
    error = np.diag(found.K) / strip(t) - 1.0
    estimate = np.diag(scaled(np.asarray(found.error_estimate), found.K))
    assert np.abs(error).max() < 1e-4
    assert np.all(np.abs(error) < 1.5 * estimate + 1e-8)
    assert found.provenance["round_off"] is None or found.provenance["round_off"] < 1e-5
    assert found.warnings == ()


@pytest.mark.one_end
def test_open_arc_with_a_very_thin_wall() -> None:
    """Rounding leaves no positive pivots of half a tube: torsion and shear centre of thin walls."""
    t = 1e-5
    sizes = {"outer_radius": 1.0 + 0.5 * t, "wall": t, "start_deg": -90.0, "span_deg": 180.0}
    found = analyse(described("tube", {**sizes, "density": ARC}), estimate=False)
    GJ = np.pi * t**3 / 3.0 * G
    assert 1.0 / np.linalg.inv(found.K)[3, 3] == pytest.approx(GJ, rel=0.03)  # 2e-3 with ARC = 0.5
    assert found.shear_centre == pytest.approx([4.0 / np.pi, 0.0], abs=1e-6)
    assert np.diag(found.K)[[0, 4]] == pytest.approx([np.pi * t, 0.5 * np.pi * t], rel=1e-5)
    assert found.provenance["round_off"] < 1e-10
    assert found.warnings == ()


@pytest.mark.one_end
def test_box_with_very_thin_walls() -> None:
    """Corners make its equations worse than those of a tube: GJ of Bredt, EA, EI."""
    t, b, h = 1e-5, 1.0, 0.5
    wall = {"plies": [{"material": "m"}], "direction": {"vector": [1.0, 0.0]}}
    spec = {
        "mesh": expand("box", {"width": b + t, "height": h + t, "wall": t}),
        "materials": {"m": {"kind": "isotropic", "E": 1.0, "nu": NU, "rho": 1.0}},
        "regions": {name: wall for name in ("top", "right", "bottom", "left")},
    }
    found = analyse(spec)
    GJ = 4.0 * (b * h) ** 2 / (2.0 * (b + h)) * G * t
    EI = t * h**2 * (h / 6.0 + b / 2.0)
    assert 1.0 / np.linalg.inv(found.K)[3, 3] == pytest.approx(GJ, rel=2e-5)
    assert found.K[0, 0] == pytest.approx(2.0 * (b + h) * t, rel=1e-8)
    assert found.K[4, 4] == pytest.approx(EI, rel=1e-6)
    assert found.provenance["round_off"] < 1e-6
    assert found.warnings == ()


@pytest.mark.one_end
def test_both_kinds_of_unknowns_give_the_same_stiffness() -> None:
    """Where both are accurate: a wall of 1/30."""
    spec = described("rectangle", {"width": 1.0, "height": 1.0 / 30.0})
    problem = SectionProblem(section_mesh(spec["mesh"], "strip"), 2)
    C = np.broadcast_to(isotropic(1.0, NU, 1.0).stiffness_M, (problem.space.n_cell, 1, 6, 6))
    plain = problem.solve(C)
    assert plain.space is problem.space
    problem._is_thin = True
    thin = problem.solve(C)
    assert thin.space is not problem.space
    assert scaled(thin.K - plain.K, plain.K).max() < 1e-8


def test_numbering_from_the_opposite_corner_changes_nothing() -> None:
    """But the round-off of a thin wall, which it shows."""
    spec = described("tube", {"outer_radius": 1.0, "wall": 0.1, "span_deg": 200.0})
    mesh = section_mesh(spec["mesh"], "tube")
    other = replace(mesh, cells=turned(mesh.cells))
    assert not np.array_equal(other.cells.nodes, mesh.cells.nodes)
    C = np.broadcast_to(isotropic(1.0, NU, 1.0).stiffness_M, (mesh.cells.n_cell, 1, 6, 6))
    K = [SectionProblem(one, 2).solve(C).K for one in (mesh, other)]
    assert scaled(K[1] - K[0], K[0]).max() < 1e-11


def test_differences_are_another_basis_of_the_same_functions() -> None:
    spec = described("tube", {"outer_radius": 1.0, "wall": 0.01})
    space = SectionSpace(section_mesh(spec["mesh"], "tube").cells)
    unknowns = differences_across(space.unknowns_at_nodes()[1], space.dofs)
    assert unknowns is not None
    other = space.expressed(unknowns)
    one = unknowns.R @ unknowns.P
    assert abs(one - np.eye(one.shape[0])).max() < 1e-14
    nodal = np.random.default_rng(0).standard_normal((space.n_dof, 2))
    z = unknowns.of_nodes(nodal.reshape(-1, 3, 2)).reshape(-1, 2)
    for name in ("strain_in_section", "strain_along_beam", "at_points"):
        ours, theirs = getattr(space, name)(nodal), getattr(other, name)(z)
        assert np.abs(ours - theirs).max() < 1e-11 * np.abs(ours).max()


def test_round_mesh_without_thin_cells_keeps_its_unknowns() -> None:
    spec = described("ellipse", {"radius_2": 2.0, "radius_3": 1.0})
    space = SectionSpace(section_mesh(spec["mesh"], "ellipse").cells)
    unknowns = differences_across(space.unknowns_at_nodes()[1], space.dofs)
    assert unknowns is None or len(unknowns.whole) > 0


@pytest.mark.one_end
@pytest.mark.parametrize("t", on_one_end(0.1, 1e-2))
@pytest.mark.parametrize("soft", ["faces", "core"])
def test_stiffness_ratio(soft: str, t: float) -> None:
    """Two faces and a core with moduli 1 and 1e-9: EA and EI by rule of mixture (equal nu)."""
    hard_core = soft == "faces"
    E = {"face": 1e-9 if hard_core else 1.0, "core": 1.0 if hard_core else 1e-9}
    materials = {
        name: {"kind": "isotropic", "E": value, "nu": NU, "rho": 1.0} for name, value in E.items()
    }
    plies = [
        {"material": "face", "thickness": 0.1 * t},
        {"material": "core", "thickness": 0.8 * t},
        {"material": "face", "thickness": 0.1 * t},
    ]
    found = analyse(described("rectangle", {"width": 1.0, "height": t}, materials, plies))
    EA = (0.2 * E["face"] + 0.8 * E["core"]) * t
    EI = (E["face"] * (1.0 - 0.8**3) + E["core"] * 0.8**3) * t**3 / 12.0
    assert found.K[0, 0] == pytest.approx(EA, rel=1e-8)
    assert found.K[4, 4] == pytest.approx(EI, rel=1e-6)
    assert found.provenance["round_off"] < 1e-6
    assert found.warnings == ()


@pytest.mark.one_end
@pytest.mark.provokes("ill-conditioned")
def test_what_looks_singular_is_allowed_on_request() -> None:
    """A core of a modulus 1e-13 times that of the faces hardly holds them together."""
    materials = {
        name: {"kind": "isotropic", "E": E, "nu": NU, "rho": 1.0}
        for name, E in (("face", 1.0), ("core", 1e-13))
    }
    plies = [{"material": m, "thickness": 0.2} for m in ("face", "core", "face")]
    spec = described("rectangle", {"width": 1.0, "height": 0.6}, materials, plies)
    with pytest.raises(SectionError, match=r'singular .* allow = \["ill-conditioned"\]'):
        analyse(spec)
    found = analyse({**spec, "allow": ["ill-conditioned"]})
    assert [w["code"] for w in found.warnings] == ["ill-conditioned"]
    assert found.K[0, 0] == pytest.approx(0.4, rel=1e-8)


BALSA = {
    "kind": "orthotropic",
    **{"E1": 1e7, "E2": 1e7, "E3": 2.73e9, "G12": 2e6, "G13": 1e7, "G23": 1e7},
    **{"nu12": 0.3, "nu13": 0.01, "nu23": 0.01, "rho": 110.0},
}


def test_shear_soft_is_not_incompressible() -> None:
    assert bulk_over_shear(isotropic(3.0, 0.3, 1.0)) == pytest.approx(2.6 / (3 * 0.4))
    assert bulk_over_shear(isotropic(3.0, 0.499, 1.0)) > 400.0
    honeycomb = {**BALSA, "G12": 1e3, "G13": 1e4, "G23": 1e4}
    assert bulk_over_shear(material_from_dict(honeycomb, "m")) < 3.0


@pytest.mark.provokes("nearly-incompressible", "degree-1-locks", "coarse-mesh")
def test_a_material_that_locks_is_allowed_on_request(tmp_path: Any) -> None:
    file = tmp_path / "square.npz"
    x = np.linspace(-0.5, 0.5, 5)
    points = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    i, j = np.divmod(np.arange(16), 4)
    first = 5 * i + j
    cells = np.stack([first, first + 5, first + 6, first + 1], axis=1)
    np.savez(
        file,
        points=points,
        cells=cells,
        cell_type="quad",
        region=np.zeros(16, int),
        region_names=["section"],
        lines=np.zeros((0, 2), int),
        curve=[],
        curve_names=[],
    )
    rubber = {"m": {"kind": "isotropic", "E": 1.0, "nu": 0.49, "rho": 1.0}}
    spec = {
        "name": "square",
        "mesh": {"arrays": str(file), "degree": 1},
        "materials": rubber,
        "regions": {"section": {"plies": [{"material": "m"}]}},
    }
    with pytest.raises(SectionError, match=r'incompressible .*lock; allow = \["nearly-inc'):
        analyse(spec)
    codes = [w["code"] for w in analyse({**spec, "allow": ["nearly-incompressible"]}).warnings]
    assert codes == ["degree-1-locks", "nearly-incompressible", "coarse-mesh"]


CARBON = {
    "kind": "orthotropic", "E1": 142e9, "E2": 9.8e9, "E3": 9.8e9, "G12": 6e9, "G13": 6e9,
    "G23": 4.8e9, "nu12": 0.3, "nu13": 0.3, "nu23": 0.42, "rho": 1.0,
}  # fmt: skip


def membrane_tube(A: Any) -> Any:
    """K of a thin tube of radius 1 whose wall has the stiffness A (3, 3): a statically determinate
    membrane without hoop force. Loads: columns of axial force and shear flow along y2."""
    angle = np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False)
    x2, x3, none = np.cos(angle), np.sin(angle), 0.0 * angle
    axial = np.stack([none + 0.5, none, none, none, x3, -x2]) / np.pi
    flow = np.stack([none, x3, -x2, none - 0.5, none, none]) / np.pi
    a = np.linalg.inv(A)[np.ix_([0, 2], [0, 2])]
    loads = np.stack([axial, flow])
    return np.linalg.inv(np.einsum("pis,pq,qjs->ij", loads, a, loads) * 2.0 * np.pi / 360)


@pytest.mark.one_end
@pytest.mark.parametrize("angles", [[45.0], [45.0, -45.0], [0.0, 45.0, -45.0, 90.0]])
@pytest.mark.parametrize("t", on_one_end(1e-4, 1e-5))
def test_laminated_tube(t: float, angles: list[float]) -> None:
    """Plies of t R / 4 keep their places although the edges of the mesh are parabolas."""
    ply = t / len(angles)
    plies = [{"material": "m", "angle_deg": angle, "thickness": ply} for angle in angles]
    sizes = {"outer_radius": 1.0 + 0.5 * t, "wall": t}
    found = analyse(described("tube", sizes, {"m": CARBON}, plies))
    material = material_from_dict(CARBON, "m")
    laminate = Laminate(tuple(Lamina(material, angle, ply) for angle in angles))
    expected = membrane_tube(laminate_stiffness(laminate).A)
    error = scaled(found.K - expected, expected)
    # the closed form lacks terms of the order t / R
    assert (error <= scaled(np.asarray(found.error_estimate), expected) + 2.0 * t).all()
    assert scaled(np.asarray(found.error_estimate), expected).max() < 5e-5
    assert found.warnings == ()


@pytest.mark.one_end
@pytest.mark.parametrize("t", on_one_end(1e-3, 1e-5))
@pytest.mark.parametrize(("angles", "ratio"), [(None, 1e-9), ((45.0, -45.0), 1e-3)])
def test_sandwich_tube(t: float, angles: tuple[float, float] | None, ratio: float) -> None:
    """Thin faces of one isotropic material, or of 45 and -45 deg, on a core that is nearly void."""
    core = {"kind": "isotropic", "E": 142e9 * ratio, "nu": NU, "rho": 1.0}
    face = CARBON if angles else core | {"E": 142e9}
    outside, inside = angles or (0.0, 0.0)
    layers = [("f", outside, 0.1), ("c", 0.0, 0.8), ("f", inside, 0.1)]
    plies = [
        {"material": name, "angle_deg": angle, "thickness": share * t}
        for name, angle, share in layers
    ]
    sizes = {"outer_radius": 1.0 + 0.5 * t, "wall": t}
    found = analyse(described("tube", sizes, {"f": face, "c": core}, plies))
    materials = {"f": material_from_dict(face, "f"), "c": material_from_dict(core, "c")}
    laminate = Laminate(
        tuple(Lamina(materials[name], angle, share * t) for name, angle, share in layers)
    )
    expected = membrane_tube(laminate_stiffness(laminate).A)
    error = scaled(found.K - expected, expected)
    estimate = scaled(np.asarray(found.error_estimate), expected)
    # the closed form lacks terms of the order t / R: the face outside is larger than that inside
    assert (error <= estimate + 10.0 * t).all()
    assert estimate.max() < 5e-5
    assert found.provenance["round_off"] < 1e-9
    assert found.warnings == ()


def test_estimate_contains_the_distance_from_circles() -> None:
    """Field and mesh: the estimate is above the true error, whatever the degree."""
    t = 0.01
    for degree in (2, 3):
        spec = described("tube", {"outer_radius": 1.0 + 0.5 * t, "wall": t}, degree=degree)
        found = analyse(spec)
        error = np.abs(np.diag(found.K) / tube(t) - 1.0)
        estimate = np.diag(scaled(np.asarray(found.error_estimate), found.K))
        assert (error <= 1.01 * estimate).all()
        assert (estimate < 4.0 * error.max()).all()
