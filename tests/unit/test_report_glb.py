"""motion.glb: read back as a viewer does it, the mechanism is where the solver put it."""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.result_samples import swinging_rod

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.math.rotations import rotation_matrix
from plymotion.solver.report.animation import write_glb
from plymotion.solver.results import RunResult, read_result

pytest.importorskip("matplotlib")

RUN = "layup-2"


@pytest.fixture(scope="module")
def result(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, RunResult]:
    """Path of motion.glb of a short run of the double pendulum, and its result."""
    folder = tmp_path_factory.mktemp("case")
    text = (repository / "cases/double-pendulum/case.toml").read_text()
    (folder / "case.toml").write_text(text.replace("t_end = 1.0", "t_end = 0.05"))
    packages = repository / "tests/packages/double-pendulum"
    build = folder / "build"
    command = [str(folder / "case.toml"), "--run", RUN, "--packages", str(packages)]
    assert main([*command, "--out", str(build), "--jobs", "1", "--quiet", "--no-report"]) == 0
    assert main(["report", str(build), "--glb"]) == 0
    return build / RUN / "motion.glb", read_result(build / RUN / "result.vtkhdf")


def read(path: Path) -> tuple[dict[str, Any], list[np.ndarray]]:
    """JSON of a binary glTF file and its accessors as arrays."""
    data = path.read_bytes()
    magic, version, size = struct.unpack_from("<4sII", data)
    assert (magic, version, size) == (b"glTF", 2, len(data))
    length, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON"
    table = json.loads(data[20 : 20 + length])
    more, kind = struct.unpack_from("<I4s", data, 20 + length)
    assert kind == b"BIN\0"
    assert more % 4 == length % 4 == 0
    binary = data[28 + length :]
    arrays = []
    for accessor in table["accessors"]:
        view = table["bufferViews"][accessor["bufferView"]]
        dtype = {5126: np.float32, 5125: np.uint32}[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        values = np.frombuffer(binary, dtype, accessor["count"] * width, view["byteOffset"])
        values = values.reshape(-1, width) if width > 1 else values
        if "min" in accessor:
            rows = values.reshape(len(values), -1)
            np.testing.assert_array_equal(rows.min(axis=0), accessor["min"])
            np.testing.assert_array_equal(rows.max(axis=0), accessor["max"])
        arrays.append(values)
    return table, arrays


def test_points_are_where_the_solver_put_them(result: tuple[Path, RunResult]) -> None:
    path, run = result
    table, arrays = read(path)
    (animation,) = table["animations"]
    histories: dict[tuple[int, str], np.ndarray] = {}
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        where = channel["target"]
        histories[where["node"], where["path"]] = arrays[sampler["output"]]
    assert [node["name"] for node in table["nodes"]] == ["arm", "hand"]
    for number, body in enumerate(run.bodies):
        view = body.view
        assert view is not None
        mesh = table["meshes"][number]
        (primitive,) = mesh["primitives"]
        base = arrays[primitive["attributes"]["POSITION"]].astype(float)
        targets = np.array([arrays[each["POSITION"]] for each in primitive["targets"]], float)
        m = len(targets)
        weights = histories[number, "weights"].reshape(-1, m)
        assert weights.min() >= 0.0
        assert weights.max() <= 1.0
        assert mesh["extras"]["targetNames"] == list(view.labels)
        assert len(weights) == len(run.t)
        for row in (0, len(run.t) // 3, len(run.t) - 1):
            x, y, z, w = histories[number, "rotation"][row].astype(float)
            A = rotation_matrix(np.array([w, x, y, z]))
            moved = base + np.einsum("m,mpa->pa", weights[row], targets)
            found = histories[number, "translation"][row] + moved @ A.T
            q = run.q[row, view.first_position : view.first_position + 7 + m]
            bent = np.einsum("m,mna->na", q[7:], view.shapes_B)[view.surface.node]
            offset = view.surface.offset_B
            b = body.nodes_B[view.surface.node] + offset + bent[:, :3]
            expected = q[:3] + (b + np.cross(bent[:, 3:], offset)) @ rotation_matrix(q[3:7]).T
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6)
            if row:
                still = histories[number, "translation"][row] + base @ A.T
                assert np.abs(still - expected).max() > 1e-5


def test_rotations_have_no_jumps(result: tuple[Path, RunResult]) -> None:
    table, arrays = read(result[0])
    (animation,) = table["animations"]
    for channel in animation["channels"]:
        if channel["target"]["path"] == "rotation":
            turn = arrays[animation["samplers"][channel["sampler"]]["output"]].astype(float)
            np.testing.assert_allclose(np.linalg.norm(turn, axis=1), 1.0, rtol=1e-6)
            assert np.linalg.norm(np.diff(turn, axis=0), axis=1).max() < 0.5


def test_the_file_says_that_its_base_is_not_at_rest(result: tuple[Path, RunResult]) -> None:
    table, _ = read(result[0])
    assert "not undeformed" in table["asset"]["extras"]["note"]


def test_result_without_surfaces_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"result\.vtkhdf: has no surfaces of bodies"):
        write_glb(tmp_path / "motion.glb", swinging_rod())
    assert not list(tmp_path.iterdir())
