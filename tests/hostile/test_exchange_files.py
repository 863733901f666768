"""Files of other codes that are cut off, or announce absurd counts: refused with words.

What changes at random is read in processes of their own: a library may end by a segmentation fault.
"""

import random
import re
import shutil
import subprocess
import sys
import tomllib

import pytest
from harness.hostile_changes import changed, places, toml_file
from harness.hostile_profile import count, tries
from harness.processes import this_python
from samples.brick_model import brick
from samples.exchange_samples import exported, write_matrices

from plymotion.preprocess.exchange.__main__ import main as exchange

NUMBER = re.compile(rb"-?\d+(\.\d*)?([eEdD][+-]?\d+)?")
VALUES = [
    b"99999999999999999999",
    b"4000000000",
    b"-1",
    b"0",
    b"1e308",
    b"1e999",
    b"nan",
    b"",
    b"x",
]
VALUES += [b"\xff", b"1.5", b"1e", b"9" * 5000]
TABLE = """
format = 1
body = "arm"
from = "{source}"
units = {{ length = "m", mass = "kg", time = "s" }}
total_mass = 0.54
reference = {{ kind = "clamped", at = "root" }}
modes = [{{ kind = "lowest", count = 2 }}]
interfaces.root = {{ nodes = [1], link = "average" }}
interfaces.tip = {{ nodes = [2], link = "average" }}
[files]
{source} = "arm.{source}"
masses = "arm_masses.csv"
"""
# Reads changed copies one after the other; tells the one that it is at.
READING = """
import contextlib, io, sys
from pathlib import Path
from plymotion.preprocess.exchange.__main__ import main
from plymotion.solver.package.validation import validate
for folder in sorted(Path(sys.argv[1]).iterdir()):
    told = io.StringIO()
    print(folder.name, flush=True)
    with contextlib.redirect_stderr(told):
        code = main(["import", str(folder / "arm.toml"), "--out", str(folder / "o.vtkhdf"),
                     "--quiet"])
    assert code in (0, 2), code
    assert code != 2 or str(folder) in told.getvalue(), told.getvalue()
    if code == 0:
        wrong = [f for f in validate(folder / "o.vtkhdf") if f.level == "error"]
        assert not wrong, wrong
    print("END", {0: "done", 2: "refused"}[code], flush=True)
"""


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    """Folders of files that can be imported, and the files of each that are changed."""
    folder = tmp_path_factory.mktemp("exchange")
    file = write_matrices(folder / "matrices", brick((0.5, 0.04, 0.01), (4, 1, 1), density=2700.0))
    package = folder / "arm.vtkhdf"
    assert exchange(["import", str(file), "--out", str(package), "--quiet"]) == 0
    for source in ("uff", "med"):
        (folder / source).mkdir()
        exported(package, source, folder / source / f"arm.{source}")
        text = TABLE.format(source=source)
        (folder / source / "arm.toml").write_text(text)
    shutil.copy(folder / "uff/arm_masses.csv", folder / "med")
    for source in ("uff", "med"):  # otherwise no change would reach its reader
        words = ["import", str(folder / source / "arm.toml"), "--out", str(folder / "o.vtkhdf")]
        assert exchange([*words, "--quiet"]) == 0
    return {
        folder / "matrices": ["K.mtx", "M.mtx", "nodes.csv", "dofs.csv", "cells.csv"],
        folder / "uff": ["arm.uff", "arm_masses.csv"],
        folder / "med": ["arm.med"],
    }


def _changed(content, chance):
    """Cut off at any byte, or one number changed, or one line left out."""
    kind = chance.choice(["cut", "number", "number", "line"])
    if kind == "cut":
        return content[: chance.randrange(len(content))]
    if kind == "number":
        found = list(NUMBER.finditer(content))
        place = chance.choice(found[:20] if chance.random() < 0.5 else found)
        return content[: place.start()] + chance.choice(VALUES) + content[place.end() :]
    lines = content.split(b"\n")
    del lines[chance.randrange(min(len(lines), 12))]
    return b"\n".join(lines)


def test_changed_files_of_other_codes(sources, tmp_path):
    chance = random.Random(1)
    for k in range(tries(40, 400)):
        folder, names = chance.choice(list(sources.items()))
        copy = tmp_path / "copies" / f"{k:04d}"
        shutil.copytree(folder, copy)
        file = copy / chance.choice(names)
        file.write_bytes(_changed(file.read_bytes(), chance))
    for end in _read(tmp_path / "copies"):
        count("import: a changed file of another code", end)


def test_changed_import_files(sources, tmp_path):
    """One value of the import file itself: what is written is what `validate` accepts."""
    chance = random.Random(2)
    for k in range(tries(20, 300)):
        folder = chance.choice(list(sources))
        copy = tmp_path / "copies" / f"{k:04d}"
        shutil.copytree(folder, copy)
        whole = tomllib.loads((copy / "arm.toml").read_text("utf-8"))
        table, _ = changed(chance, {"damping_ratio": 0.01, **whole}, places(whole))
        (copy / "arm.toml").write_text(toml_file(table), "utf-8")
    for end in _read(tmp_path / "copies"):
        count("import: a changed import file", end)


@pytest.mark.parametrize("line", ["format = " + "9" * 5000, "format = " + "[" * 5000])
def test_an_import_file_that_is_not_read(tmp_path, capfd, line):
    file = tmp_path / "arm.toml"
    file.write_text(line, "utf-8")
    assert exchange(["import", str(file), "-o", str(tmp_path / "o.vtkhdf"), "--quiet"]) == 2
    assert f"{file}: " in capfd.readouterr().err


@pytest.mark.parametrize("ratio", ["1e300", "1.0", "-0.1"])
def test_a_damping_ratio_is_a_fraction_of_critical(sources, tmp_path, capfd, ratio):
    copy = tmp_path / "copy"
    shutil.copytree(next(iter(sources)), copy)
    file = copy / "arm.toml"
    text = file.read_text("utf-8")
    file.write_text(text.replace("damping_ratio = 0.01", f"damping_ratio = {ratio}"), "utf-8")
    assert exchange(["import", str(file), "-o", str(copy / "o.vtkhdf"), "--quiet"]) == 2
    assert f"arm.toml: damping_ratio = {float(ratio):g}: expected" in capfd.readouterr().err
    assert not (copy / "o.vtkhdf").exists()


def _read(copies):
    """Import all; return how each ended."""
    words = [sys.executable, "-c", READING, str(copies)]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, (done.returncode, done.stdout.split()[-1], done.stderr[-2000:])
    return re.findall("^END (.*)$", done.stdout, re.MULTILINE)


SIZE = "60 60 966\n"
ODD_MATRICES = {
    "a number is cut off": SIZE + "1 1 1.62e",
    "a line is cut off": SIZE + "1",
    "entries": "60 60 4000000000\n1 1 1.0\n",
    "rows": "4000000000 4000000000 1\n1 1 1.0\n",
    "no rows": "0 60 0\n",
    "a byte of zero": SIZE + "1 1 1\x00.0\n" * 966,
    "bytes of zero": SIZE + "\x00" * 5000,
    "a row beyond the last": SIZE + "61 1 1.0\n" * 966,
    "a row of 0": SIZE + "0 1 1.0\n" * 966,
    "comments without end": "%" * 100_000,
}


@pytest.mark.parametrize("name", ODD_MATRICES)
def test_damaged_matrices_are_refused(sources, tmp_path, monkeypatch, capfd, name):
    folder = next(iter(sources))
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    text = "%%MatrixMarket matrix coordinate real symmetric\n" + ODD_MATRICES[name]
    (copy / "M.mtx").write_text(text)
    monkeypatch.chdir(copy)
    assert exchange(["import", "arm.toml", "-o", "o.vtkhdf", "--quiet"]) == 2
    told = capfd.readouterr().err
    assert "M.mtx" in told
    assert "Traceback" not in told
    assert not (copy / "o.vtkhdf").exists()


ENDED = """
import os, signal, sys
if "plymotion.preprocess.exchange" in sys.orig_argv:
    os.kill(os.getpid(), signal.SIGSEGV)
"""


def test_a_process_that_a_signal_ends_is_told(sources, tmp_path):
    (tmp_path / "sitecustomize.py").write_text(ENDED)
    folder = next(iter(sources))
    words = ["import", str(folder / "arm.toml"), "-o", str(tmp_path / "o.vtkhdf")]
    done = this_python("-m", "plymotion", *words, more={"PYTHONPATH": str(tmp_path)})
    assert done.returncode == 70
    assert "arm.toml: the process was ended: Segmentation fault" in done.stderr
    assert not (tmp_path / "o.vtkhdf").exists()
