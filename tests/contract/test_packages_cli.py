"""`plymotion packages`, and batches on a dask cluster: real commands, the real FEniCSx."""

import json
import shutil

import numpy as np
import pytest
from harness.dask_cluster import Cluster
from samples.case_samples import HEAD
from samples.sweep_samples import checked

from plymotion.solver.__main__ import main
from plymotion.solver.package import read_package
from plymotion.solver.package.section.section_file import read_section

CASE = """
[materials.steel]
kind = "isotropic"
E = 2.1e11
nu = 0.3
rho = 7800.0
[sections.bar]
shape = "rectangle"
width = 0.04
height = 0.01
[bodies.rod]
kind = "beam"
length = 0.5
section = "bar"
material = "steel"
elements = 4
modes = [{ kind = "bending-xy", count = 1 }]
interfaces = { root = { at = "start" } }
[ground.O]
position = [0.0, 0.0, 0.0]
[joints.hinge]
kind = "revolute"
between = ["ground.O", "rod.root"]
axis = [0.0, 0.0, 1.0]
[signals.x]
kind = "deflection"
at = "rod.root"
component = "x"
[solver]
t_end = 0.01
output_step = 0.01
[runs.base]
[sweeps.s]
run = "base"
[sweeps.s.vary]
"bodies.rod.length" = [0.3, 0.4, 0.5]
"""
SECTION = """
format = 1
title = "a bar"
[mesh]
shape = "rectangle"
width = 0.06
height = 0.015
[materials.steel]
kind = "isotropic"
E = 2.1e11
nu = 0.3
rho = 7800.0
[regions.section]
material = "steel"
"""


pytestmark = pytest.mark.usefixtures("fenicsx")


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    pytest.importorskip("distributed", reason="dask.distributed is not installed")
    found = Cluster(tmp_path_factory.mktemp("cluster"))
    found.worker()  # several: tests/cases/test_executors.py
    yield found
    found.close()


def _numbers(build):
    return {file.name: read_package(file).frequencies.tobytes() for file in build.rglob("*.vtkhdf")}


def test_packages_of_a_sweep_and_of_a_run(tmp_path, capfd, cluster):
    """Each once, a bad one alone; on a cluster the same numbers."""
    file = checked(tmp_path, HEAD + CASE) / "s.json"
    build = file.parent.parent
    bad = min((build / "sweeps/bodies").glob("*.json"))
    spec = json.loads(bad.read_text())
    bad.write_text(json.dumps(spec | {"kind": "unknown"}))
    assert main(["packages", str(file), str(build / "runs/base.json"), "--jobs", "2"]) == 3
    told = capfd.readouterr().err
    assert f"error: {bad}: " in told
    assert f"{bad.parent}: not built, see the messages above: {bad.stem}" in told
    bad.write_text(json.dumps(spec))
    assert main(["packages", str(file)]) == 0
    told = capfd.readouterr().err
    assert [line.split(":")[0] for line in told.splitlines()] == [bad.stem]
    found = _numbers(build)
    assert len(found) == 3
    assert main(["packages", str(file)]) == 0
    assert capfd.readouterr().err == ""
    shutil.rmtree(build)
    checked(tmp_path, HEAD + CASE)
    assert main(["packages", str(file), "--scheduler", str(cluster.file)]) == 0
    assert _numbers(build) == found


def test_a_batch_of_sections_on_a_cluster(tmp_path, cluster):
    for k in range(4):
        text = SECTION.replace("0.015", f"{0.015 + 0.001 * (k // 2)}").replace("0.3", f"0.3{k}")
        (tmp_path / f"bar-{k}.toml").write_text(text)
    words = ["section", "--batch", str(tmp_path / "bar-*.toml"), "--no-estimate", "--out"]
    assert main([*words, str(tmp_path / "here"), "--quiet"]) == 0
    there = [str(tmp_path / "there"), "--quiet", "--scheduler", str(cluster.file)]
    assert main([*words, *there]) == 0
    for k in range(4):
        one, two = (
            read_section(tmp_path / f / f"bar-{k}/bar-{k}.vtkhdf") for f in ("here", "there")
        )
        np.testing.assert_array_equal(one.K, two.K)


@pytest.mark.parametrize("text", ["[]", '{"packages": 3}', '{"packages": [{"file": 1}]}', ""])
def test_what_names_no_packages(tmp_path, capsys, text):
    file = tmp_path / "x.json"
    file.write_text(text)
    assert main(["packages", str(file)]) == 2
    assert f"error: {file}: not a run or sweep file" in capsys.readouterr().err
