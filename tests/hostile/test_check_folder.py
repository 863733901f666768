"""`check` leaves files alone that are not its own."""

import json

import pytest
from samples.case_samples import HEAD, SOLVER, rigid
from samples.sweep_samples import BALL, MASS

from plymotion.solver.__main__ import main

CASE = HEAD + rigid("ball", 1.0, 0.1, {"c": (0, 0, 0)}) + SOLVER.format(t_end=1, step=1, more="")
OTHER = "[runs.other]\n"
OURS = ["case.json", "manifest.json", "runs"]


def _check(folder, text=CASE):
    (folder / "case.toml").write_text(text)
    return main(["check", str(folder / "case.toml"), "--out", str(folder / "out")])


def _foreign(out):
    names = ["bodies/mine.vtkhdf", "bodies/mine.json", "sweeps/mine.json", "sweeps/mine.built"]
    names += ["runs/mine.json", "notes.json", "inputs/mine", "sweeps/bodies/mine.vtkhdf"]
    for name in names:
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_text(name)
    return names


def test_files_of_others_stay(tmp_path):
    names = _foreign(tmp_path / "out")
    for text in (CASE + OTHER, CASE):
        assert _check(tmp_path, text) == 0
        assert all((tmp_path / "out" / name).read_text() == name for name in names)
    assert (tmp_path / "out/runs/base.json").is_file()
    assert not (tmp_path / "out/runs/other.json").exists()  # its own


def _sweep(name, masses):
    return f'[sweeps.{name}]\nrun = "base"\nvary = {{ {MASS} = {masses} }}\n'


def test_a_run_leaves_the_files_of_sweeps_as_they_are(tmp_path, capsys):
    """It makes and checks no member: a sweep may have thousands."""
    file, out = tmp_path / "case.toml", tmp_path / "out"
    assert _check(tmp_path, BALL + _sweep("s", "[1.0, 2.0]") + _sweep("gone", "[1.0]")) == 0
    before = (out / "sweeps/s.json").read_bytes()
    file.write_text(BALL + _sweep("s", "[1.0, -2.0]"))
    assert main(["run", str(file), "--run", "base", "--out", str(out), "--no-report"]) == 0
    assert (out / "sweeps/s.json").read_bytes() == before
    assert not (out / "sweeps/gone.json").exists()
    assert main(["run", str(file), "--sweep", "s", "--out", str(out)]) == 2
    assert "sweeps.s: bodies.ball.mass = -2: value should be greater" in capsys.readouterr().err
    assert _check(tmp_path, BALL) == 0
    assert not (out / "sweeps/s.json").exists()


@pytest.mark.parametrize("name", ["case.json", "runs/base.json", "manifest.json"])
def test_no_file_of_others_is_replaced(tmp_path, capsys, name):
    file = tmp_path / "out" / name
    file.parent.mkdir(parents=True)
    file.write_text('{"mine": 1}')
    assert _check(tmp_path) == 2
    told = capsys.readouterr().err
    assert f"--out {tmp_path / 'out'}: {name} already exists and was not written by" in told
    assert file.read_text() == '{"mine": 1}'
    assert [f for f in (tmp_path / "out").rglob("*") if f.is_file()] == [file]


def test_manifest_from_elsewhere_deletes_nothing_outside(tmp_path):
    assert _check(tmp_path) == 0
    kept = [tmp_path / "mine", tmp_path / "out/notes", tmp_path / "out/runs.txt"]
    for file in kept:
        file.write_text("mine")
    names = [
        "../mine",
        str(tmp_path / "mine"),
        "runs/../../mine",
        "notes",
        "runs.txt",
        "runs/..",
        7,
    ]
    manifest = tmp_path / "out/manifest.json"
    manifest.write_text(json.dumps({"written_by": "plymotion check", "files": names}))
    (tmp_path / "out/case.json").unlink()
    (tmp_path / "out/runs/base.json").unlink()
    assert _check(tmp_path) == 0
    assert all(file.read_text() == "mine" for file in kept)


@pytest.mark.parametrize("damage", ["", "{", "[]", '{"written_by": "plymotion check", "files": 7}'])
def test_a_damaged_manifest_is_no_obstacle(tmp_path, damage):
    assert _check(tmp_path, CASE + OTHER) == 0
    (tmp_path / "out/manifest.json").write_text(damage)
    assert _check(tmp_path) == 0
    assert _check(tmp_path) == 0
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == OURS


def test_a_check_that_was_killed_is_completed(tmp_path, monkeypatch):
    """Between any two files: the next one writes all, and removes what is no longer wanted."""
    from plymotion.solver.inputs.case import write as output_folder

    write = output_folder.write_text
    for before_death in range(6):
        written = []

        def dying(file, text, own=False, written=written, most=before_death):
            if len(written) == most:
                raise KeyboardInterrupt
            written.append(file)
            write(file, text, own=own)

        monkeypatch.setattr(output_folder, "write_text", dying)
        code = _check(tmp_path, CASE + OTHER)
        monkeypatch.undo()
        assert code in (130, 0)
        assert _check(tmp_path) == 0
        assert [p.name for p in (tmp_path / "out/runs").iterdir()] == ["base.json"]
        assert sorted(p.name for p in (tmp_path / "out").iterdir()) == OURS


@pytest.mark.parametrize("name", ["runs", "bodies", "sweeps"])
def test_reserved_names_of_runs(tmp_path, capsys, name):
    assert _check(tmp_path, CASE + f"[runs.{name}]\n") == 2
    told = capsys.readouterr().err
    assert f"case.toml: runs.{name}: expected another name" in told
    assert not (tmp_path / "out").exists()


def test_reserved_name_of_a_sweep(tmp_path, capsys):
    sweep = '[sweeps.bodies]\nrun = "base"\nvary = { "bodies.ball.mass" = [1.0, 2.0] }\n'
    assert _check(tmp_path, CASE + sweep) == 2
    assert "sweeps.bodies: expected another name" in capsys.readouterr().err
