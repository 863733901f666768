"""Measured modes: files as a test engineer has them become packages, or a message that helps."""

import re
from pathlib import Path

import numpy as np
import pytest
from samples.beam_samples import CLAMPED, MEAN_AXIS, Beam, reduced

from plymotion.preprocess.beam.beam_stations import mass_stations
from plymotion.solver.__main__ import main
from plymotion.solver.extras.measured_modes import (
    INERTIAS,
    MeasuredFile,
    MeasuredInterface,
    MeasuredMode,
    MeasuredReference,
)
from plymotion.solver.package import ModalPackage, read_package, validate

IMPORT = ("import", "--from", "measured")
MODES = [{"kind": "bending-xy", "count": 3}, {"kind": "torsion", "count": 1}]
SCALES = (1.0, 0.3, -7.0, 40.0)


def beam_of(kind: str, **changes: object) -> Beam:
    reference = CLAMPED if kind == "clamped" else MEAN_AXIS
    return reduced(reference, MODES, elements=8, mass_form="lumped", mass=CENTRED, **changes)


CENTRED = np.diag([1.0, 1.0, 1.0, 0.03, 0.018, 0.012])
TOML = """
format = 1
body = "beam"
title = "hammer test"
nodes = "nodes.csv"
lines = [[1, 2, 3, 4, 5, 6, 7, 8, 9]]

[reference]
{reference}

{modes}
[interfaces.root]
nodes = [1]

[interfaces.tip]
nodes = [9]
"""


def write_test(
    folder: Path, beam: Beam, *, rotations: bool = True, noise: float = 0.0, rigid: float = 0.0
) -> Path:
    """Files of a test in which a beam's modes were measured, in arbitrary scale."""
    package = beam.package
    rng = np.random.default_rng(4)
    J = package.node_inertia_B
    nodes = ["node, x, y, z, mass, Jxx, Jyy, Jzz"]
    for k, x in enumerate(package.nodes_B):
        values = [*x, package.node_mass[k], J[k, 0, 0], J[k, 1, 1], J[k, 2, 2]]
        nodes.append(f"{k + 1}, " + ", ".join(f"{v:.17g}" for v in values))
    (folder / "nodes.csv").write_text("\n".join(nodes) + "\n")
    count = 6 if rotations else 3
    entries = []
    for i, shape in enumerate(package.shapes_B):
        scaled = SCALES[i] * shape[:, :count]
        scaled = scaled + noise * np.abs(scaled).max() * rng.standard_normal(scaled.shape)
        scaled[:, 1] += rigid * np.abs(scaled).max()
        rows = [
            "# accelerometers",
            ";".join(["node", "ux", "uy", "uz", "rx", "ry", "rz"][: count + 1]),
        ]
        for k, row in enumerate(scaled):
            if k > 0 or package.reference_condition != "clamped":
                rows.append(";".join([str(k + 1), *(f"{v:.17g}" for v in row)]))
        (folder / f"mode-{i + 1}.csv").write_text("\n".join(rows) + "\n\n")
        hz = package.frequencies[i] / (2.0 * np.pi)
        entries.append(
            f'[[modes]]\nfrequency_hz = {hz:.17g}\nshape = "mode-{i + 1}.csv"\n'
            f'damping_ratio = 0.01\nlabel = "{package.mode_labels[i]}"\n'
        )
    kind = package.reference_condition
    reference = f'kind = "{kind}"' + ('\nat = "root"' if kind == "clamped" else "")
    file = folder / "test.toml"
    file.write_text(TOML.format(reference=reference, modes="\n".join(reversed(entries))))
    return file


def imported(file: Path) -> ModalPackage:
    out = file.parent / "out.vtkhdf"
    assert main([*IMPORT, str(file), "--out", str(out)]) == 0
    assert [f for f in validate(out) if f.level != "note"] == []
    return read_package(out)


@pytest.mark.parametrize("kind", ["clamped", "mean-axis"])
def test_perfectly_measured_modes_give_the_package_of_the_fe_model(
    kind: str, tmp_path: Path
) -> None:
    beam = beam_of(kind)
    found, expected = imported(write_test(tmp_path, beam)), beam.package
    assert found.provenance["warnings"] == []
    assert found.mode_kinds == ("experimental",) * 4
    assert found.mode_labels == expected.mode_labels
    assert found.reference_condition == kind
    np.testing.assert_allclose(found.frequencies, expected.frequencies, rtol=1e-12)
    np.testing.assert_allclose(found.damping, np.diag(0.02 * expected.frequencies), rtol=1e-12)
    sign = np.sign(SCALES)
    np.testing.assert_allclose(found.shapes_B, sign[:, None, None] * expected.shapes_B, atol=1e-11)
    # those of the nodes with their rotary inertia, without points around them
    nodes = mass_stations(beam.model.line, beam.modes.columns_B, "lumped").invariants("lumped")
    for name in ("mass", "S0_B", "T00_B", "J0_B"):
        np.testing.assert_allclose(
            getattr(found.invariants, name), getattr(nodes, name), atol=1e-12
        )
    np.testing.assert_allclose(found.invariants.S_B, nodes.S_B * sign, atol=1e-11)
    turned = np.einsum("abij,i,j->abij", nodes.T11_B, sign, sign)
    np.testing.assert_allclose(found.invariants.T11_B, turned, atol=1e-11)
    tip = found.interfaces[1]
    np.testing.assert_allclose(tip.psi_B, beam.interface("tip").psi_B * sign, atol=1e-10)


def test_noise_is_turned_into_orthonormal_shapes(tmp_path: Path) -> None:
    beam = beam_of("clamped")
    found = imported(write_test(tmp_path, beam, noise=0.002))
    X = found.shapes_B
    gram = np.einsum("n,ina,jna->ij", found.node_mass, X[..., :3], X[..., :3])
    gram += np.einsum("ina,nab,jnb->ij", X[..., 3:], found.node_inertia_B, X[..., 3:])
    assert np.abs(gram - np.eye(4)).max() < 1e-12
    np.testing.assert_allclose(found.frequencies, beam.package.frequencies, rtol=1e-12)
    error = np.abs(X - np.sign(SCALES)[:, None, None] * beam.package.shapes_B).max(axis=(1, 2))
    assert (error < 0.03 * np.abs(beam.package.shapes_B).max(axis=(1, 2))).all()


@pytest.mark.provokes("measured-shapes-coupled")
def test_shapes_with_much_noise_are_not_orthogonal(tmp_path: Path, capsys) -> None:
    found = imported(write_test(tmp_path, beam_of("clamped"), noise=0.2))
    assert {w["code"] for w in found.provenance["warnings"]} == {"measured-shapes-coupled"}
    assert "made orthogonal to the first" in capsys.readouterr().err


@pytest.mark.provokes("measured-shape-rigid")
def test_motion_of_the_suspension_is_taken_out(tmp_path: Path, capsys) -> None:
    beam = beam_of("mean-axis")
    found = imported(write_test(tmp_path, beam, rigid=0.2))
    sign = np.sign(SCALES)[:, None, None]
    np.testing.assert_allclose(found.shapes_B, sign * beam.package.shapes_B, atol=1e-10)
    assert {w["code"] for w in found.provenance["warnings"]} == {"measured-shape-rigid"}
    assert "rigid-body motion" in capsys.readouterr().err


def test_rotation_of_an_interface_from_the_displacements_of_its_nodes(tmp_path: Path) -> None:
    """A plate end of four nodes that turns about z and x: the rigid motion of the four."""
    nodes = ["node,x,y,z,mass", "1,0,0,0,1"]
    rng = np.random.default_rng(0)
    place = np.array([[1.0, 0, 0.1], [1.0, 0.2, 0], [1.1, -0.1, 0], [0.9, 0, -0.2]])
    nodes += [f"{k + 2},{x},{y},{z},0.5" for k, (x, y, z) in enumerate(place)]
    (tmp_path / "nodes.csv").write_text("\n".join(nodes))
    turn, shift = rng.normal(size=3), rng.normal(size=3)
    moved = shift + np.cross(turn, place)
    rows = ["node,ux,uy,uz"] + [f"{k + 2},{u},{v},{w}" for k, (u, v, w) in enumerate(moved)]
    (tmp_path / "one.csv").write_text("\n".join(rows))
    (tmp_path / "test.toml").write_text(
        'format = 1\nbody = "plate"\nnodes = "nodes.csv"\n'
        'reference = { kind = "clamped", at = "root" }\n'
        'modes = [{ frequency_hz = 3.0, shape = "one.csv" }]\n'
        "interfaces = { root = { nodes = [1] }, tip = { nodes = [2, 3, 4, 5] } }\n"
    )
    found = imported(tmp_path / "test.toml")
    tip = found.interfaces[1]
    scale = np.sqrt(0.5 * (moved**2).sum())
    assert tip.kind == "average"
    np.testing.assert_allclose(tip.psi_B[:, 0] * scale, turn, rtol=1e-12)
    np.testing.assert_allclose(tip.phi_B[:, 0] * scale, moved.mean(axis=0), rtol=1e-12)
    assert found.mode_labels == ("one",)
    assert found.provenance["warnings"] == []


@pytest.mark.provokes("interface-without-rotation")
def test_interface_without_rotations_is_doubted(tmp_path: Path) -> None:
    found = imported(write_test(tmp_path, beam_of("clamped"), rotations=False))
    codes = [w["code"] for w in found.provenance["warnings"]]
    assert codes.count("interface-without-rotation") == 1  # the root is held: it does not turn
    assert np.abs(found.interfaces[1].psi_B).max() == 0.0


BAD = {
    "key": ('title = "', 'titel = "', "test.toml", r"titel: unknown key; did you mean 'title'"),
    "frequency": ("frequency_hz = ", "frequency_hz = -", "test.toml", r"modes.*greater than 0"),
    "reference": ('at = "root"', 'at = "rot"', "test.toml", r'reference.at = "rot".*\'root\''),
    "no place": ('at = "root"', "", "test.toml", "expected `at` with an interface"),
    "node": ("nodes = [9]", "nodes = [10]", "test.toml", r"interfaces.tip.nodes = \[10\]: .*10"),
    "no file": ("mode-1.csv", "mode-7.csv", "test.toml", r"mode-7.csv: no such file"),
    "column": (
        "mass, Jxx",
        "mass, Jx",
        "nodes.csv",
        r"nodes.csv:1: column 'Jx': unknown; did you mean 'Jx",
    ),
    "missing": (", mass", ", mas", "nodes.csv", r"nodes.csv:1: column 'mas': unknown"),
    "comma": ("0.125,", '"0,125",', "nodes.csv", r"nodes.csv:3: column 'x': expected a number"),
    "short": ("\n9, ", "\n9, 1.0, ", "nodes.csv", r"nodes.csv:10: expected 8 values, found 9"),
    "twice": ("\n8, ", "\n9, ", "nodes.csv", r"node 9 occurs twice"),
    "gone": ("\n5;", "\n# 5;", "mode-2.csv", r"mode-2.csv: node 5: missing"),
    "strange": ("\n5;", "\n50;", "mode-2.csv", r"mode-2.csv: node 50: expected one of the nodes"),
    "flat": (
        "ux;uy;uz;rx;ry;rz",
        "rx;ry;rz;ux;ux;ux",
        "mode-1.csv",
        r"mode-1.csv:2: column 'ux': occurs twice",
    ),
}


@pytest.mark.parametrize("name", list(BAD))
def test_message_says_where_and_what(name: str, tmp_path: Path, capsys) -> None:
    old, new, where, message = BAD[name]
    file = write_test(tmp_path, beam_of("clamped"))
    text = (tmp_path / where).read_text()
    assert old in text
    (tmp_path / where).write_text(text.replace(old, new, 1))
    assert main([*IMPORT, str(file), "--out", str(tmp_path / "out.vtkhdf")]) == 2
    error = capsys.readouterr().err
    assert re.search(message, error), error
    assert not (tmp_path / "out.vtkhdf").exists()


def test_held_interface_must_be_at_rest(tmp_path: Path, capsys) -> None:
    file = write_test(tmp_path, beam_of("mean-axis"))
    file.write_text(file.read_text().replace('kind = "mean-axis"', 'kind = "clamped"\nat = "root"'))
    assert main([*IMPORT, str(file), "--out", str(tmp_path / "out.vtkhdf")]) == 2
    assert 'use reference.kind = "mean-axis"' in capsys.readouterr().err


def test_same_shape_twice(tmp_path: Path, capsys) -> None:
    file = write_test(tmp_path, beam_of("clamped"))
    file.write_text(file.read_text().replace("mode-2.csv", "mode-1.csv"))
    assert main([*IMPORT, str(file), "--out", str(tmp_path / "out.vtkhdf")]) == 2
    assert "are not independent (cosine 1.000" in capsys.readouterr().err


@pytest.mark.provokes("measured-modal-mass")
def test_mass_normalised_shapes_are_compared_with_the_nodes(tmp_path: Path, capsys) -> None:
    file = write_test(tmp_path, beam_of("clamped"))
    file.write_text(file.read_text().replace("nodes =", "mass_normalised = true\nnodes =", 1))
    found = imported(file)
    doubts = [w for w in found.provenance["warnings"] if w["code"] == "measured-modal-mass"]
    assert len(doubts) == 3  # one of the four was not rescaled
    capsys.readouterr()


def test_manual_names_every_key(repository: Path) -> None:
    text = (repository / "docs/modes.md").read_text(encoding="utf-8")
    tables = (MeasuredFile, MeasuredMode, MeasuredReference, MeasuredInterface)
    keys = [name for table in tables for name in table.model_fields]
    assert [key for key in [*keys, *INERTIAS] if f"`{key}`" not in text] == []


def test_a_file_of_others_is_not_replaced(tmp_path, capsys) -> None:
    file, out = write_test(tmp_path, beam_of("clamped")), tmp_path / "out.vtkhdf"
    other = tmp_path / "thesis.txt"
    for path in (out, other):
        path.write_text("the only copy of a thesis\n")
        assert main([*IMPORT, str(file), "--out", str(out)]) == 2
        assert f"{out}: already exists and was not written by" in capsys.readouterr().err
        assert path.read_text() == "the only copy of a thesis\n"
        out.unlink()
        out.symlink_to(other)
    assert out.is_symlink()
    out.unlink()
    for _ in range(2):
        assert main([*IMPORT, str(file), "--out", str(out)]) == 0
