"""Derivatives of packages by design parameters against differences of rebuilt packages."""

import re
from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from peers.package_rates import errors
from samples.body_specs import CLAMPED, beam_body, shell_body
from samples.section_specs import library_spec
from samples.shell_specs import CFRP, METAL, plate

from plymotion.preprocess import body as preprocess_body
from plymotion.preprocess.beam.line import SectionMass
from plymotion.preprocess.body import build_body
from plymotion.preprocess.design import body_parameters
from plymotion.preprocess.modes.reference import ModeError
from plymotion.preprocess.products import BodyPackages
from plymotion.preprocess.shell.body import shell_body as built_shells
from plymotion.solver.errors import PackageError
from plymotion.solver.package import ModalPackage, read_package, validate, write_package
from plymotion.solver.package.body.lay_ups import LayUp
from plymotion.solver.package.common.plain_data import SpecError

pytestmark = pytest.mark.one_end

LIMIT = 1e-7  # of each dataset, by a change of the parameter by as much as its value
LEFT_OUT = {
    "stresses": r"sections/.*/(plies|recovery)/",
    "second_order": r"second_order/|interfaces/.*/H_",
    "ply_axes": r"sections/.*/recovery/A_BM",
}
MEAN, CHORD = {"kind": "mean-axis"}, {"kind": "chord", "at": ["root", "tip"]}
STIFF = np.array([1e7, 3e6, 3e6, 2e3, 3e3, 3e3])
MASS = SectionMass(1.0, np.array([0.0, 0.01, -0.02]), np.diag([2e-3, 1e-3, 1e-3])).matrix()


def coupled() -> dict[str, Any]:
    """A section that couples everything; bending in both planes has close frequencies."""
    A = np.random.default_rng(1).standard_normal((6, 6))
    K = (np.eye(6) + 0.05 * (A + A.T)) * np.sqrt(np.outer(STIFF, STIFF))
    return {"stiffness": K.tolist(), "mass": MASS.tolist(), "trapeze": [1e-3, 0, 0, 1e-4, 0, 0]}


def square() -> dict[str, Any]:
    """The section of a square tube of one material: frequencies in pairs."""
    mass = np.diag([1.0, 1.0, 1.0, 2e-3, 1e-3, 1e-3])
    return {"stiffness": np.diag(STIFF).tolist(), "mass": mass.tolist(), "trapeze": [0.0] * 6}


def entry(i: int, j: int, factor: float = 1.0, at: str = "section") -> list[dict[str, Any]]:
    """An entry of a stiffness and its mirror image."""
    places = sorted({(i, j), (j, i)})
    return [{"of": f"{at}.stiffness.{a}.{b}", "factor": factor} for a, b in places]


def beam(section: dict[str, Any], count: int, **changes: Any) -> dict[str, Any]:
    modes = [
        {"kind": "lowest", "count": count},
        {"kind": "attachment", "at": "tip"},
        {"kind": "static-axial"},
    ]
    given = {"length": 0.8, "elements": 8, "modes": modes, "damping_ratio": 0.02}
    return beam_body(body="arm", section=section, **given | changes)


def skewed(**changes: Any) -> dict[str, Any]:
    """A plate of a coupled lay-up, its mesh off its mid-plane."""
    plies = [
        {"material": "cfrp", "angle_deg": float(a), "thickness": 1e-3} for a in (30, -45, 0, 60)
    ]
    table = plate((8, 3), 1.0, 0.4, 0.1)
    shell = {
        "mesh": table["mesh"],
        "materials": {"cfrp": CFRP},
        "laminates": {"skin": {"plies": plies, "offset": 1e-3}},
        "regions": {"all": {"laminate": "skin", "axis": [1.0, 0.2, 0.0]}},
    }
    modes = [{"kind": "lowest", "count": 5}, {"kind": "attachment", "at": "tip"}]
    ends = {"root": {"at": "left"}, "tip": {"at": "right"}}
    given = {"modes": modes, "interfaces": ends, "damping_ratio": 0.01}
    return shell_body(body="panel", shell=shell, **given | changes)


RIB = {
    "at": "top",
    "stiffness": np.diag([1e6, 3e5, 3e5, 20.0, 30.0, 30.0]).tolist(),
    "mass": (0.1 * np.diag([1, 1, 1, 2e-4, 1e-4, 1e-4])).tolist(),
    "offset": [0.0, 0.01],
}


@pytest.mark.parametrize(
    ("elements", "more"),
    [
        ({}, {}),
        ({"membrane": "cst", "drilling": "fictitious"}, {}),
        ({}, {"stiffeners": {"rib": RIB}}),
    ],
    ids=["opt", "cst", "stiffened"],
)
def test_other_lay_ups_in_the_same_modes(elements: dict[str, str], more: dict[str, Any]) -> None:
    """K of a package for other plies is that of a new model with these plies, in its modes."""
    spec = skewed()
    spec["shell"] |= {"elements": {"plate": "dkt"} | elements, **more}
    spec["design"] = {"a": [{"of": "shell.laminates.skin.plies.0.angle_deg"}]}
    package = build_body(spec)
    skin = LayUp(package, "skin")
    assert (skin.stiffness(skin.angles_deg) == package.stiffness).all()
    model = built_shells.shell_model(built_shells.read_shell_body(spec))
    u = model.problem.freedom.expanded(built_shells.shell_modes(model).columns_B)
    plies = spec["shell"]["laminates"]["skin"]["plies"]
    others = ((10, 80, -33, 5), None), ((90, 0, 45, -45), (2e-3, 1e-3, 1e-3, 4e-4))
    for angles, thicknesses in others:
        for ply, angle, h in zip(plies, angles, thicknesses or skin.thicknesses, strict=True):
            ply |= {"angle_deg": float(angle), "thickness": float(h)}
        other = built_shells.shell_model(built_shells.read_shell_body(spec)).problem
        K, found = u.T @ (other.K @ u), skin.stiffness(angles, thicknesses)
        assert np.abs(found - K).max() < 1e-10 * np.abs(K).max()
        np.testing.assert_array_equal(skin.stiffness([angles], thicknesses)[0], found)
    with pytest.raises(PackageError, match="lay-up: expected numbers of 4 plies"):
        skin.stiffness([0.0, 90.0])


@pytest.mark.parametrize(
    ("elements", "cells", "why"),
    [
        ({}, "triangle", "elements.plate = dkmt depends on the transverse shear"),
        ({"plate": "dkt", "beta0": "felippa"}, "triangle", "beta0 = felippa depends on ratios"),
        ({}, "quadrilateral", "quadrilaterals depends on the inverse of A"),
    ],
)
def test_other_elements_have_no_such_matrices(elements: Any, cells: str, why: str) -> None:
    spec = skewed(design={"a": [{"of": "shell.laminates.skin.offset"}]})
    spec["shell"] |= {"elements": elements, "mesh": spec["shell"]["mesh"] | {"element": cells}}
    package = build_body(spec)
    with pytest.raises(PackageError, match=f"laminate skin: no `stiffness_rates.*{why}"):
        LayUp(package)
    with pytest.raises(PackageError, match="laminate 'core': expected one of skin"):
        LayUp(package, "core")


def worst(spec: dict[str, Any], steps: float) -> dict[str, float]:
    """Largest error of the derivatives of all datasets, by parameter."""
    package, found = build_body(spec), {}
    for parameter in body_parameters(spec):

        def rebuilt(distance: float, by: Any = parameter) -> ModalPackage:
            return build_body({k: v for k, v in by.moved(distance).items() if k != "design"})

        found[parameter.name] = max(errors(package, parameter, rebuilt, steps).values())
    return found


SIXES = {
    "bend": entry(4, 4),
    "couple": entry(3, 4) + entry(5, 5, -0.5),
    "heavy": [{"of": f"section.mass.{i}.{i}"} for i in range(3)],
}


@pytest.mark.parametrize(
    ("reference", "mass_form"),
    [(CLAMPED, "consistent"), (MEAN, "lumped"), (MEAN, "consistent"), (CHORD, "consistent")],
)
def test_beams_of_any_6x6(reference: dict[str, Any], mass_form: str) -> None:
    design = SIXES | {"ratio": [{"of": "damping_ratio"}]}
    section = coupled()
    if mass_form == "consistent":  # mass alone may change only without mass off the line
        section["mass"] = square()["mass"]
    else:
        del design["heavy"]
    spec = beam(section, 5, reference=reference, mass_form=mass_form, design=design)
    found = worst(spec, 1.0)
    assert found.keys() == design.keys()
    assert max(found.values()) < LIMIT, found


@pytest.mark.parametrize("reference", [CLAMPED, MEAN])
def test_clusters_of_a_square_section(reference: dict[str, Any]) -> None:
    """Equal frequencies: a change that couples both planes has terms outside the diagonal."""
    count = 7 if reference is CLAMPED else 6
    spec = beam(square(), count, reference=reference, design={"a": entry(4, 5), "b": entry(4, 4)})
    found = worst(spec, 3.0)
    assert max(found.values()) < LIMIT, found
    package = build_body(spec)
    rate = package.design[0].values["modes/stiffness"]
    assert abs(rate[0, 1]) > 0.1 * package.stiffness[0, 0] / STIFF[5]
    assert package.stiffness[1, 1] == pytest.approx(package.stiffness[0, 0], rel=1e-10)
    # eigenvalues of the changed cluster: those of its derivative, K44 +- K45
    np.testing.assert_allclose(
        np.linalg.eigvalsh(rate[:2, :2]), abs(rate[0, 1]) * np.array([-1, 1]), rtol=1e-6
    )


def test_a_mode_of_a_pair_alone_has_no_derivative_if_it_turns() -> None:
    spec = beam(square(), 7, modes=[{"kind": "bending-xy", "count": 2}])
    package = build_body(spec | {"design": {"b": entry(4, 4)}})  # stays in its plane
    assert set(package.design[0].values) > {"modes/frequencies"}
    with pytest.raises(ModeError, match=r"design\.a: it couples a selected mode with one of the"):
        build_body(spec | {"design": {"a": entry(4, 5)}})


def test_curved_tapered_classical_and_spinning_beams() -> None:
    angle = np.linspace(0.0, 1.0, 9)
    nodes = np.column_stack([np.sin(angle), 1.0 - np.cos(angle), 0.1 * angle**2])
    line = {"nodes": nodes.tolist(), "x2_axes": [[0.0, 1.0, 0.2]] * 8}
    thin = {"stiffness": (0.5 * np.diag(STIFF)).tolist(), "mass": (0.7 * MASS).tolist()}
    stations = [
        {"at": 0.0, "section": coupled()},
        {"at": 1.0, "section": thin | {"trapeze": [0.0] * 6}},
    ]
    design = {
        "tip": entry(4, 4, at="stations.1.section"),
        "root": entry(0, 4, at="stations.0.section"),
    }
    curved = beam(coupled(), 4, line=line, length=1.01, stations=stations, design=design)
    spinning = [{"kind": "bending-xy", "count": 2}, {"kind": "spinning-xy", "count": 2}]
    straight = beam(square(), 0, theory="classical", modes=spinning, design={"b": entry(5, 5)})
    assert max(worst(curved, 1.0).values()) < LIMIT
    # shear that is held 1e8 times as stiff as bending: resultants are small differences
    assert max(worst(straight, 1.0).values()) < 100.0 * LIMIT


@pytest.mark.parametrize("shape", ["tube", "box"])
def test_ply_angles_of_round_and_square_tubes(shape: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Section, modes in pairs, recovery: angles of all walls together, and of one."""
    monkeypatch.setattr(preprocess_body, "thinned", lambda recovery: recovery)
    sizes = {"outer_radius": 0.03} if shape == "tube" else {"width": 0.05, "height": 0.05}
    section = library_spec(shape, sizes | {"wall": 0.004}, CFRP)
    regions = section["regions"]
    for table in regions.values():
        table["plies"] = [{"material": "m", "angle_deg": angle} for angle in (30.0, -20.0)]
    inner = [{"of": f"section.regions.{name}.plies.1.angle_deg"} for name in regions]
    design = {"all": inner, "one": [inner[0] | {"factor": -1.0}]}
    design["outer"] = [{"of": f"section.regions.{next(iter(regions))}.plies.0.angle_deg"}]
    modes = [{"kind": "lowest", "count": 7}, {"kind": "attachment", "at": "tip"}]
    found = worst(beam(section, 0, modes=modes, design=design), 1.0)
    assert found.keys() == design.keys()
    assert max(found.values()) < LIMIT, found
    # the last of the parameters is a combination of others
    design["both"] = design["outer"] + design["one"]
    spec = beam(section, 0, modes=modes, design=design)
    whole = build_body(spec).design
    for without in (["stresses"], ["second_order", "ply_axes"], ["stresses", "second_order"]):
        left_out = "|".join(LEFT_OUT[name] for name in without)
        for one, part in zip(
            whole, build_body({**spec, "design_without": without}).design, strict=True
        ):
            expected = {p: x for p, x in one.values.items() if not re.match(left_out, p)}
            assert f"sections/{shape}/K" in part.values
            assert part.values.keys() == expected.keys()
            for path, rate in part.values.items():
                size = np.abs(expected[path]).max()
                np.testing.assert_allclose(rate, expected[path], rtol=0.0, atol=LIMIT * size)


PLIES = "shell.laminates.skin.plies"
LAYUP = {
    "turn": [{"of": f"{PLIES}.0.angle_deg"}],
    "pair": [{"of": f"{PLIES}.1.angle_deg"}, {"of": f"{PLIES}.3.angle_deg", "factor": -1.0}],
    "thick": [{"of": f"{PLIES}.2.thickness"}],
    "E2": [{"of": "shell.materials.cfrp.E2"}],
}


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"reference": MEAN, "mass_form": "lumped"},
        {"reference": CHORD, "second_order": True},
    ],
    ids=["clamped", "mean-axis", "second order"],
)
def test_lay_ups_of_shells(changes: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        built_shells, "rounded", lambda values: values
    )  # differences need all digits
    found = worst(skewed(design=LAYUP, **changes), 5.0)
    assert found.keys() == LAYUP.keys()
    assert max(found.values()) < LIMIT, found


def test_the_file_has_them(tmp_path: Path) -> None:
    design = {"turn": [LAYUP["turn"][0] | {"factor": 2.0, "offset": 10.0}]}
    package = build_body(skewed(design=design))
    write_package(tmp_path / "a.vtkhdf", package)
    assert [f for f in validate(tmp_path / "a.vtkhdf") if f.level != "note"] == []
    (found,) = read_package(tmp_path / "a.vtkhdf").design
    assert (found.name, found.kind, list(found.targets)) == ("turn", "angle", design["turn"])
    np.testing.assert_allclose(found.values["laminates/skin/plies/angle_deg"], [2.0, 0, 0, 0])
    assert "modes/mass" not in found.values


@pytest.mark.parametrize(
    ("of", "message"),
    [
        ("shell.laminates.skn.plies.0.angle_deg", "no 'skn' in shell.laminates.*skin"),
        ("shell.laminates.skin.plies.7.thickness", "no '7' in shell.laminates.skin.plies"),
        ("shell.laminates.skin.plies.0.material", "expected a number that can be a design para"),
        ("shell.materials.cfrp.strength", "expected the path of a number, found|no 'strength'"),
        ("shell.mesh.scale", "no 'scale'|expected a number that can be a design parameter"),
    ],
)
def test_wrong_targets_are_named(of: str, message: str) -> None:
    with pytest.raises(SpecError, match=rf"design\.a\[0\]\.of.*({message})"):
        build_body(skewed(design={"a": [{"of": of}]}))


@pytest.mark.parametrize("kind", ["solid", "imported"])
def test_other_bodies_refuse_design_parameters(kind: str, tmp_path: Path) -> None:
    spec = {"kind": kind, "design": {"a": [{"of": "solid.materials.a.E"}]}}
    with pytest.raises(SpecError, match=rf"design: a body of kind '{kind}' has no derivatives"):
        BodyPackages(Namespace()).make(spec, tmp_path / "a.vtkhdf")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", ["region", "stiffener"])
def test_regions_of_one_material_and_stiffeners(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(built_shells, "rounded", lambda values: values)
    spec = skewed()
    if kind == "region":
        spec["shell"] |= {"materials": {"metal": METAL}, "laminates": {}}
        region = {"material": "metal", "thickness": 3e-3, "offset": 0.0, "axis": [1.0, 0.0, 0.0]}
        spec["shell"]["regions"] = {"all": region}
        places = ["regions.all.thickness", "regions.all.offset", "materials.metal.rho"]
    else:
        spec["shell"]["stiffeners"] = {"rib": RIB}
        places = ["stiffeners.rib.stiffness.4.4", "laminates.skin.plies.0.angle_deg"]
    spec["design"] = {f"p{k}": [{"of": f"shell.{place}"}] for k, place in enumerate(places)}
    found = worst(spec, 1.0)
    assert len(found) == len(places)
    assert max(found.values()) < LIMIT, found
