"""Shells as bodies: the modal package against the model that it was made from."""

import json
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from peers.ply_stresses import shell_file_ply_stress, shell_ply_stress
from samples.body_specs import CLAMPED, beam_body, shell_body
from samples.section_specs import rectangle_spec
from samples.shell_specs import CFRP, METAL, box, plate

from plymotion.preprocess.body import build_body
from plymotion.preprocess.modes.reference import ModeError
from plymotion.preprocess.products import BodyPackages
from plymotion.preprocess.shell.analyses.shell_analysis import analyse
from plymotion.preprocess.shell.body.interfaces import read_shell_body
from plymotion.preprocess.shell.body.shell_body import shell_model, shell_modes, shell_package
from plymotion.preprocess.shell.shell_cells import ShellError
from plymotion.solver.package import ModalPackage, read_package, validate, write_package
from plymotion.solver.package.body.invariants import free_body_mass, rigid_motions
from plymotion.solver.package.body.plausibility import plausibility_findings
from plymotion.solver.package.common.plain_data import SpecError

Record = Callable[[str, Any], None]
PARTS = ("mesh", "materials", "laminates", "regions", "elements", "stiffeners")
LENGTH, WIDTH, THICKNESS = 0.675, 0.04, 0.010
ENDS = {"plate": ("left", "right"), "box": ("root", "tip")}


def body(shell: dict[str, Any], **changes: Any) -> dict[str, Any]:
    """A specification with interfaces at both ends."""
    root, tip = ENDS[shell["name"]]
    entries = {
        "shell": {key: shell[key] for key in PARTS if key in shell},
        "modes": [{"kind": "lowest", "count": 6}],
        "interfaces": {"root": {"at": root}, "tip": {"at": tip}},
        "damping_ratio": 0.01,
        **changes,
    }
    return shell_body(body="hand", **entries)


def built(spec: dict[str, Any]) -> ModalPackage:
    """The package of a specification with some changes."""
    return build_body(shell_body(**spec))


def hand(n: tuple[int, int] = (24, 4), **changes: Any) -> dict[str, Any]:
    return body(plate(n, THICKNESS, LENGTH, WIDTH), **changes)


def skewed(offset: float = 0.0, **changes: Any) -> dict[str, Any]:
    """A coupled lay-up, its mesh off its mid-plane: membrane, bending and inertia all couple."""
    plies = [
        {"material": "cfrp", "angle_deg": float(a), "thickness": 1e-3} for a in (30, -45, 0, 60)
    ]
    shell = plate((12, 4), 1.0, 0.4, 0.1)
    shell["materials"] = {"cfrp": CFRP}
    shell["laminates"] = {"skin": {"plies": plies, "offset": offset}}
    shell["regions"] = {"all": {"laminate": "skin", "axis": [1.0, 0.2, 0.0]}}
    return body(shell, **changes)


@pytest.mark.one_end
@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
@pytest.mark.parametrize(
    "reference",
    [CLAMPED, {"kind": "mean-axis"}, {"kind": "chord", "at": ["root", "tip"]}],
    ids=lambda r: r["kind"],
)
def test_package_is_sound(tmp_path: Path, mass_form: str, reference: dict[str, Any]) -> None:
    modes = [{"kind": "lowest", "count": 5}, {"kind": "attachment", "at": "tip"}]
    spec = skewed(1e-3, mass_form=mass_form, reference=reference, modes=modes)
    spec["interfaces"]["mid"] = {"at": "centre"}
    spec["interfaces"]["edge"] = {"at": "top", "link": "average", "position": [0.1, 0.0, 0.2]}
    package = built(spec)
    write_package(tmp_path / "a.vtkhdf", package)
    assert [f for f in validate(tmp_path / "a.vtkhdf") if f.level != "note"] == []
    assert package.mode_kinds[:5] == ("fixed_normal",) * 5
    assert set(package.cell_types) == {5}
    assert np.allclose(package.damping, np.diag(0.02 * package.frequencies))
    total = 0.4 * 0.1 * 4e-3 * CFRP["rho"]
    assert package.invariants.mass == pytest.approx(total, rel=1e-12)
    assert package.node_mass.sum() == pytest.approx(total, rel=1e-12)
    kinds = {i.name: (i.kind, len(i.node_ids)) for i in package.interfaces}
    end = ("node", 1) if reference["kind"] == "chord" else ("average", 5)
    assert kinds == {"root": end, "tip": end, "mid": ("node", 1), "edge": ("node", 1)}


@pytest.mark.one_end
def test_chord_of_a_hollow_body(tmp_path: Path) -> None:
    """Its ends are centres of rims, where the mesh has no node."""
    spec = body(box(), reference={"kind": "chord", "at": ["root", "tip"]})
    write_package(tmp_path / "box.vtkhdf", built(spec))
    assert [f for f in validate(tmp_path / "box.vtkhdf") if f.level != "note"] == []


def test_body_without_modes_is_rigid() -> None:
    package = built(hand((4, 2), modes=[]))
    assert package.n_mode == 0
    assert package.invariants.mass == pytest.approx(LENGTH * WIDTH * THICKNESS * METAL["rho"])


def stiffened(**changes: Any) -> dict[str, Any]:
    """A plate with a rib along its middle, off the mesh."""
    spec = hand((8, 4), **changes)
    rib = {
        "at": "bottom",
        "stiffness": np.diag([2e7, 6e6, 6e6, 90.0, 170.0, 170.0]).tolist(),
        "mass": np.diag([0.27, 0.27, 0.27, 4.5e-6, 2.25e-6, 2.25e-6]).tolist(),
        "offset": [0.002, 0.012],
    }
    spec["shell"]["stiffeners"] = {"rib": rib}
    return spec


@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
@pytest.mark.parametrize("make", [skewed, stiffened])
def test_energy_of_the_package_is_that_of_the_model(
    make: Callable[..., dict[str, Any]], mass_form: str
) -> None:
    """1/2 v' M v for rigid and modal motion together, R' M X included, to round-off."""
    offset = {"offset": 1e-3} if make is skewed else {}
    spec = make(mass_form=mass_form, reference={"kind": "mean-axis"}, **offset)
    spec["modes"] = [{"kind": "lowest", "count": 3}, {"kind": "attachment", "at": "tip"}]
    model = shell_model(read_shell_body(shell_body(**spec)))
    modes = shell_modes(model)
    package = shell_package(model, modes, {})
    problem, mesh = model.problem, model.problem.mesh
    rigid = np.zeros((problem.freedom.n_dof, 6))
    rigid[: 6 * mesh.n_node] = rigid_motions(mesh.points_G).reshape(-1, 6)
    motion = np.hstack([rigid, problem.freedom.expanded(modes.columns_B)])
    exact = motion.T @ (problem.M @ motion)
    scale = np.sqrt(np.diag(exact))
    gap = np.abs(free_body_mass(package) - exact) / np.outer(scale, scale)
    assert gap[:6].max() < 1e-13
    assert gap.max() < 1e-9  # modes are orthonormal to this
    translation = np.einsum("aaij->ij", package.invariants.T11_B)
    assert np.linalg.eigvalsh(np.eye(len(translation)) - translation)[0] > -1e-12


def test_a_plate_is_a_beam(record: Record) -> None:
    """Frequencies and invariants of the hand of the double pendulum, nu = 0, against its beam."""
    metal = {**METAL, "nu": 0.0}
    spec = hand((48, 4), modes=[{"kind": "bending-xy", "count": 2}])
    spec["modes"].append({"kind": "bending-xz", "count": 3})
    spec["shell"]["materials"] = {"metal": metal}
    shell = built(spec)
    section = rectangle_spec(WIDTH, THICKNESS, metal)
    beam = build_body(
        beam_body(body="hand", length=LENGTH, elements=24, section=section, modes=spec["modes"])
    )
    assert shell.mode_labels == ("along z 1", "along y 1", "along z 2", "along z 3", "along y 2")
    ratio = shell.frequencies / beam.frequencies
    record("shell body frequencies", shell.frequencies)
    assert np.abs(ratio - 1.0).max() < 5e-3
    record("shell body over beam", ratio)
    moved = shell.invariants
    centre = np.array([0.0, 0.5 * WIDTH, 0.0])  # the beam's axis in the shell's body axes
    np.testing.assert_allclose(
        moved.S0_B - moved.mass * centre, beam.invariants.S0_B, rtol=1e-9, atol=1e-9
    )
    assert moved.mass == pytest.approx(beam.invariants.mass, rel=1e-9)
    # linear momentum of the modes, and what a fibre's rotary inertia adds to a turn about y
    np.testing.assert_allclose(moved.S_B, beam.invariants.S_B, atol=5e-3 * np.sqrt(moved.mass))
    np.testing.assert_allclose(
        free_body_mass(shell)[3:6, 6:] - _shift(moved.S_B, centre),
        free_body_mass(beam)[3:6, 6:],
        atol=5e-3 * np.sqrt(moved.mass) * LENGTH,
    )
    about = free_body_mass(shell)[4, 4] / free_body_mass(beam)[4, 4]
    assert about == pytest.approx(1.0, rel=1e-6)


def _shift(S_B: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Angular momentum of the linear momentum through a point off the origin."""
    return np.cross(centre[:, None], S_B, axis=0)


def test_rigid_interface_moves_as_one() -> None:
    package = built(skewed(modes=[{"kind": "lowest", "count": 6}]))
    for place in package.interfaces:
        rows = np.searchsorted(package.node_ids, place.node_ids)
        assert np.array_equal(package.node_ids[rows], place.node_ids)
        arms = package.nodes_B[rows] - place.position_B
        carried = place.phi_B[None] + np.cross(
            place.psi_B.T[:, None], arms[None], axis=2
        ).transpose(1, 2, 0)
        found = np.moveaxis(package.shapes_B[:, rows], 0, 2)
        scale = np.abs(package.shapes_B).max()
        assert np.abs(found[:, :3] - carried).max() < 1e-12 * scale
        assert np.abs(found[:, 3:] - place.psi_B).max() < 1e-12 * scale
    root = package.interfaces[0]
    assert (np.abs(root.phi_B).max(), np.abs(root.psi_B).max()) == (0.0, 0.0)


@pytest.mark.one_end
def test_mean_axis_has_no_rigid_motion() -> None:
    spec = body(box(), reference={"kind": "mean-axis"}, modes=[{"kind": "lowest", "count": 8}])
    spec["modes"].append({"kind": "attachment", "at": "tip"})
    package = built(spec)
    M = free_body_mass(package)
    size = np.sqrt(np.diag(M))
    assert np.abs(M[:6, 6:] / np.outer(size[:6], size[6:])).max() < 1e-9
    free = analyse({**box(), "supports": {}, "frequencies": {"count": 3, "free": True}})
    assert free.modes is not None
    # rigid ends stiffen the rim of the box
    assert package.frequencies[0] == pytest.approx(free.modes.frequencies[6], rel=0.05)
    assert package.frequencies[0] >= free.modes.frequencies[6] * (1 - 1e-9)


@pytest.mark.parametrize("link", ["rigid", "average"])
def test_attachment_is_the_static_answer(link: str, record: Record) -> None:
    """One vibration and one load's shape: displacements and ply stresses of the statics."""
    force = 3.0
    spec = skewed(1e-3, modes=[{"kind": "lowest", "count": 1}])
    spec["modes"].append({"kind": "attachment", "at": "tip", "directions": ["z"]})
    spec["interfaces"]["tip"]["link"] = link
    package = built(spec)
    statics = analyse(
        {
            "name": "plate",
            **spec["shell"],
            "links": {
                "root": {"at": "left", "kind": "rigid"},
                "tip": {"at": "right", "kind": link},
            },
            "supports": {"root": {"at": "root", "fixed": "all"}},
            "loads": {"pull": {"tip": {"at": "tip", "force": [0.0, 0.0, force]}}},
        }
    )
    tip = next(i for i in package.interfaces if i.name == "tip")
    q = np.linalg.solve(package.stiffness, force * tip.phi_B[2])
    u = np.einsum("mnd,m->nd", package.shapes_B, q)
    exact = statics.cases.displacements_G[0]
    assert np.abs(u - exact).max() < 1e-8 * np.abs(exact).max()
    (expected,) = shell_file_ply_stress(statics, statics.cases.resultants_E)
    rows = range(len(package.cell_types))
    found = np.array([shell_ply_stress(package, row, q[None])[0] for row in rows])
    largest = np.abs(expected).max()
    assert np.abs(found - expected[0]).max() < 3e-6 * largest  # resultants are rounded to 5e-7
    record(f"shell body tip deflection, {link}", u[:, 2].max())
    record(f"shell body largest stress, {link}", largest)


def test_static_axial_stretches_like_a_spinning_bar() -> None:
    metal = {**METAL, "nu": 0.0}
    spec = hand((32, 2), modes=[{"kind": "static-axial"}])
    spec["shell"]["materials"] = {"metal": metal}
    package = built(spec)
    tip = next(i for i in package.interfaces if i.name == "tip")
    # modal force of m x is the first moment of the shape: T01 about the root
    load = package.invariants.T01_B[0, 0]
    stretch = tip.phi_B[0] @ np.linalg.solve(package.stiffness, load)
    exact = metal["rho"] * LENGTH**3 / (3.0 * metal["E"])
    assert stretch == pytest.approx(exact, rel=2e-3)


def test_a_thin_free_shell_keeps_its_six_rigid_motions_apart() -> None:
    shell = plate((20, 8), 2e-4, 1.0, 0.4)
    spec = body(shell, reference={"kind": "mean-axis"}, modes=[{"kind": "lowest", "count": 5}])
    package = built(spec)
    assert package.frequencies[0] > 1.0
    assert [f for f in plausibility_findings(package) if f.level != "note"] == []


@pytest.mark.one_end
def test_same_package_from_a_file_of_the_command(tmp_path: Path) -> None:
    spec = hand((8, 2))
    product, target = BodyPackages(Namespace()), tmp_path / "hand.vtkhdf"
    assert not product.unchanged(target, spec)
    text, warnings = product.make(spec, target)
    assert text.startswith("shell ")
    assert not warnings
    assert product.unchanged(target, spec)
    assert not product.unchanged(target, {**spec, "damping_ratio": 0.02})
    found = read_package(target)
    assert found.provenance["spec"] == json.loads(json.dumps(spec))
    assert set(found.provenance["seconds"]) == {"shell", "modes"}


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"mass": "x"}, SpecError, "mass: unknown key"),
        ({"interfaces": {"root": {"at": "lfet"}}}, ShellError, "lfet"),
        ({"interfaces": {"root": {"at": "left", "link": "stiff"}}}, SpecError, "link"),
        ({"reference": {"kind": "clamped", "at": "tpi"}}, SpecError, "tip"),
        ({"modes": [{"kind": "torsion", "count": 1}]}, SpecError, "lowest"),
        ({"modes": [{"kind": "lowest", "count": 5000}]}, ModeError, "5000"),
        ({"reference": {"kind": "chord", "at": ["root", "mid"]}}, SpecError, "along the body's x"),
        ({"reference": {"kind": "chord", "at": ["root", "near"]}}, SpecError, "along the body's x"),
        ({"shell": {"loads": {}}}, SpecError, "shell.loads: unknown key"),
    ],
)
def test_what_is_wrong_is_named(
    changes: dict[str, Any], error: type[Exception], words: str
) -> None:
    spec = hand((4, 2))
    spec["interfaces"]["mid"] = {"at": "corner-11"}
    at_root = [1e-11, 0.5 * WIDTH, 0.0]  # the same place but for rounding
    spec["interfaces"]["near"] = {"at": "corner-10", "position": at_root}
    del spec["interfaces"]["tip"]
    spec["interfaces"]["tip"] = {"at": "bottom", "link": "average"}
    with pytest.raises(error, match=words):
        built({**spec, **changes})
