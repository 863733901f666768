"""From specification files to modal packages: content, provenance, command line."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.body_specs import beam_body, panel_body
from samples.section_specs import rectangle_spec
from samples.shell_specs import plate

from plymotion.preprocess.__main__ import main
from plymotion.preprocess.body import build_body
from plymotion.solver.math.arrays import Array
from plymotion.solver.package import ModalPackage, read_package, validate, write_package
from plymotion.solver.package.body.invariants import inertia_at_rest
from plymotion.solver.package.common.plain_data import toml_text
from plymotion.solver.package.specification import DIRECTIONS

ROOT = Path(__file__).resolve().parent.parent.parent
ALUMINIUM = {"kind": "isotropic", "E": 70e9, "nu": 0.3, "rho": 2700.0}
MASS = 0.545 * 0.06 * 0.015 * 2700.0


def arm(**changes: Any) -> dict[str, Any]:
    entries = {
        "body": "arm",
        "length": 0.545,
        "elements": 16,
        "x2_axis": [0, 1, 0],
        "section": rectangle_spec(0.06, 0.015, ALUMINIUM),
        "mass_form": "consistent",
        "reference": {"kind": "clamped", "at": "root"},
        "modes": [{"kind": "bending-xy", "count": 4}],
        "interfaces": {"root": {"at": "start"}, "tip": {"at": "end"}, "mid": {"at": 0.5}},
        "damping_ratio": 0.01,
        "inputs_sha256": "0" * 64,
        "case": "double-pendulum",
        **changes,
    }
    return beam_body(**entries)


def test_axial_modes_of_a_long_thin_beam() -> None:
    """10 m of 2 mm: the third axial mode is the 176th of all, 1e9 times as stiff as the first."""
    light = {"kind": "isotropic", "E": 70e9, "nu": 0.3, "rho": 3000.0}
    counts = {"bending-xy": 6, "bending-xz": 6, "torsion": 3, "axial": 3}
    modes = [{"kind": kind, "count": count} for kind, count in counts.items()]
    places = {"root": {"at": "start"}, "tip": {"at": "end"}}
    section = rectangle_spec(0.0775, 0.002, light)
    package = build_body(
        arm(length=10.0, elements=48, section=section, modes=modes, interfaces=places)
    )
    speed = np.sqrt(light["E"] / light["rho"])
    axial = 2.0 * np.pi * np.array([1, 3, 5]) * speed / (4.0 * 10.0)
    assert package.frequencies[-3:] == pytest.approx(axial, rel=2e-3)


@pytest.mark.one_end
def test_errors_of_the_stiffness_are_those_of_mesh_and_section(tmp_path: Path) -> None:
    """Too stiff in twist by a section of a few cells, in bending by four elements."""
    counts = {"bending-xy": 2, "torsion": 1}
    modes = [{"kind": kind, "count": count} for kind, count in counts.items()]
    fine = rectangle_spec(0.06, 0.015, ALUMINIUM)
    parameters = fine["mesh"]["parameters"] | {"columns": [0.3, 0.7, 1.0], "rows": [1.0]}
    few = {**fine, "mesh": {**fine["mesh"], "parameters": parameters}}
    coarse, fine = (
        build_body(arm(section=section, modes=modes, elements=elements, errors=True))
        for section, elements in ((few, 4), (fine, 24))
    )
    write_package(tmp_path / "arm.vtkhdf", coarse)
    assert [f for f in validate(tmp_path / "arm.vtkhdf") if f.level == "error"] == []
    coarse = read_package(tmp_path / "arm.vtkhdf")
    rows = [coarse.mode_labels.index(label) for label in sorted(coarse.mode_labels)]
    true = [fine.mode_labels.index(label) for label in sorted(fine.mode_labels)]
    assert coarse.stiffness_error is not None
    stated = np.diag(coarse.stiffness_error)[rows] / np.diag(coarse.stiffness)[rows]
    error = np.diag(coarse.stiffness)[rows] / np.diag(fine.stiffness)[true] - 1.0
    assert error.min() > 1e-4
    assert error.max() > 1e-2
    ratio = stated / error
    assert ratio.min() > 0.8
    assert ratio.max() < 1.5


@pytest.mark.one_end
@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
def test_package_is_sound_and_complete(tmp_path: Path, mass_form: str) -> None:
    path = tmp_path / "arm.vtkhdf"
    write_package(path, build_body(arm(mass_form=mass_form)))
    assert [f for f in validate(path) if f.level != "note"] == []
    package = read_package(path)
    assert path.stat().st_size < 150_000
    assert package.mode_labels == tuple(f"bending-xy {i}" for i in (1, 2, 3, 4))
    assert package.invariants.mass == pytest.approx(MASS, rel=1e-9)
    assert package.node_mass.sum() == pytest.approx(MASS, rel=1e-9)
    assert package.node_mass[0] == pytest.approx(MASS / 32, rel=1e-9)
    assert np.allclose(package.invariants.S0_B, [MASS * 0.545 / 2, 0, 0], atol=1e-9 * MASS)
    about_y = MASS * (0.545**2 / 3 + 0.015**2 / 12)
    lumping = 0.6 / 16**2 if mass_form == "lumped" else 1e-9
    assert inertia_at_rest(package.invariants)[1, 1] == pytest.approx(about_y, rel=lumping)
    assert np.allclose(package.damping, np.diag(0.02 * package.frequencies))
    assert np.abs(package.shapes_B[:, 0]).max() == 0.0
    tip = next(i for i in package.interfaces if i.name == "tip")
    assert np.array_equal(tip.phi_B, package.shapes_B[:, -1, :3].T)
    assert np.array_equal(tip.psi_B, package.shapes_B[:, -1, 3:].T)
    assert np.allclose(tip.position_B, [0.545, 0, 0])
    assert 'kind = "isotropic"' in package.sections[0].ply_table


def test_modal_mass_is_in_the_invariants() -> None:
    package = build_body(arm())
    along, across, over = np.einsum("aaij->aij", package.invariants.T11_B)
    assert np.abs(along + across + over - np.eye(4)).max() < 1e-9
    assert np.linalg.eigvalsh(along)[0] > 0
    assert np.diag(along).max() < 0.1  # a slender beam carries little in rotation


def test_x2_axis_turns_the_section() -> None:
    flat = build_body(arm(modes=[{"kind": "bending-xz", "count": 2}]))
    turned = build_body(arm(modes=[{"kind": "bending-xy", "count": 2}], x2_axis=[0, 0, 1]))
    assert np.allclose(flat.frequencies, turned.frequencies, rtol=1e-9)


@pytest.mark.one_end
def test_tapered_and_twisted_body_is_sound(tmp_path: Path) -> None:
    """Two analysed sections, K and M between them, stresses at both."""
    slim = {**rectangle_spec(0.03, 0.010, ALUMINIUM), "name": "slim"}
    stations = [{"at": 0.0, "section": arm()["section"]}, {"at": 1.0, "section": slim}]
    angles = np.radians(5.0) * (np.arange(16) + 0.5)
    line = {
        "nodes": [[0.545 * k / 16, 0.0, 0.0] for k in range(17)],
        "x2_axes": [[0.0, float(np.cos(a)), float(np.sin(a))] for a in angles],
    }
    modes = [{"kind": "lowest", "count": 4}]
    path = tmp_path / "arm.vtkhdf"
    write_package(path, build_body(arm(stations=stations, line=line, modes=modes)))
    assert [f for f in validate(path) if f.level != "note"] == []
    package = read_package(path)
    stressed = [s.name for s in package.sections if s.recovery is not None]
    assert stressed == ["0001 rectangle", "0017 slim"]
    middle, ends = package.sections[8], (package.sections[0], package.sections[16])
    assert np.allclose(middle.K, 0.5 * (ends[0].K + ends[1].K), rtol=1e-12)
    assert package.invariants.mass == pytest.approx(0.545 * 2700.0 * (9e-4 + 3e-4) / 2, rel=1e-9)


def test_clamp_at_the_far_end() -> None:
    a = build_body(arm())
    b = build_body(arm(reference={"kind": "clamped", "at": "tip"}))
    assert np.allclose(a.frequencies, b.frequencies, rtol=1e-9)
    assert np.allclose(a.shapes_B[:, ::-1, 1], b.shapes_B[:, :, 1], atol=1e-7)


def test_provenance_says_where_it_comes_from() -> None:
    package = build_body(arm())
    found = package.provenance
    assert found["inputs_sha256"] == "0" * 64
    assert found["case"] == "double-pendulum"
    assert found["spec"] == arm()
    assert {"dolfinx", "petsc", "slepc"} <= set(found["versions"])
    assert set(found["seconds"]) == {"section", "modes"}
    assert str(ROOT) not in json.dumps(found)


def test_ply_table_reads_back() -> None:
    import tomllib

    section = arm()["section"]
    assert tomllib.loads(toml_text(section)) == section


def run(*arguments: str | Path) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "plymotion.preprocess", *map(str, arguments)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, env=environment)


@pytest.mark.one_end
def test_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    specs = {
        "arm.good": arm(),
        "arm.bad": arm(elements=0),
        "arm.metal": arm(section=rectangle_spec(0.06, 0.015, {**ALUMINIUM, "E": -1})),
        "hand": arm(body="hand"),
    }
    for name, spec in specs.items():
        (tmp_path / f"{name}.json").write_text(json.dumps(spec))
    (tmp_path / "broken.json").write_text("{")
    files = [tmp_path / f"{name}.json" for name in specs]
    out = tmp_path / "out"

    first = run("body", *files, tmp_path / "broken.json", "--out-dir", out)
    assert first.returncode == 2
    assert sorted(p.name for p in out.iterdir()) == ["arm.good.vtkhdf", "hand.vtkhdf"]
    assert "[1/5] arm.good: section " in first.stdout
    # The libraries below may have words of their own on a bare machine (hwloc without /sys).
    errors = [line for line in first.stderr.splitlines() if line.startswith("error: ")]
    assert len(errors) == 3, first.stderr
    assert "arm.bad.json: elements: expected at least 2, one between" in errors[0]
    assert "arm.metal.json" in errors[1]
    assert "section.materials.m.E = -1" in errors[1]
    assert "broken.json: not JSON" in errors[2]

    good = out / "arm.good.vtkhdf"
    content = good.read_bytes()
    os.utime(good, (1, 1))

    def again(*options: str) -> str:
        """The output of the command in this process."""
        assert main(["body", str(files[0]), "--out-dir", str(out), *options]) == 0
        return capsys.readouterr().out

    assert again() == "[1/1] arm.good: unchanged\n"
    assert good.read_bytes() == content
    assert good.stat().st_mtime == 1, "make would repeat every run that reads it"

    files[0].write_text(json.dumps(arm(elements=18)))
    assert "section" in again()
    assert len(read_package(good).node_ids) == 19
    assert "unchanged" not in again("--force")
    good.write_bytes(b"damaged")
    assert "section" in again()
    assert len(read_package(good).node_ids) == 19


def missing_compliance(package: ModalPackage) -> Array:
    """What the modes miss of the compliance under the loads at the interfaces, scaled by it."""
    F = np.vstack([np.vstack([one.phi_B, one.psi_B]) for one in package.interfaces])
    C = package.compliance[: len(F), : len(F)]
    size = np.sqrt(np.where(np.diag(C) > 0.0, np.diag(C), 1.0))
    return (C - F @ np.linalg.solve(package.stiffness, F.T)) / np.outer(size, size)


@pytest.mark.one_end
@pytest.mark.parametrize("reference", [{"kind": "clamped", "at": "root"}, {"kind": "mean-axis"}])
def test_compliance_of_a_shell(reference: dict[str, Any]) -> None:
    """Modes have a part of it, the static shapes of all loads the whole."""
    shell = plate((10, 4), 0.01, 1.0, 0.2)
    one = build_body(panel_body(shell, 1, body="panel", reference=reference))
    G = missing_compliance(one)
    values = np.linalg.eigvalsh(G)
    assert values[0] > -1e-7
    assert values[-1] > 0.5
    spec = panel_body(shell, 1, body="panel", reference=reference)
    spec["modes"] += [
        {"kind": "attachment", "at": at, "directions": list(DIRECTIONS)}
        for at in spec["interfaces"]
    ]
    assert np.abs(missing_compliance(build_body(spec))).max() < 1e-4
