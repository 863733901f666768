"""The task of a worker that has a file made: what it says when the preprocessor does not start."""

import os
import threading
import time

import pytest

import plymotion as pm
from plymotion.solver.errors import InputError
from plymotion.solver.package.common import files
from plymotion.solver.workers import launch


@pytest.mark.skipif(os.name == "nt", reason="links need a privilege there")
def test_what_a_link_names_is_made_beside_the_link(tmp_path):
    """The command looks for the file there, and writes nothing in the folders of others."""
    other, own = tmp_path / "other", tmp_path / "own"
    for folder in (other, own):
        folder.mkdir()
    (other / "spec.json").write_text("{}")
    (own / "body.json").symlink_to(other / "spec.json")
    start = launch.Start("", "body", ())
    queue = launch.SpecificationQueue([[own / "body.json"]])
    task = launch._Specifications(queue, start, lambda *_: None).next(0, 1)
    assert task.arguments == (start, own / "body.json")


@pytest.mark.skipif(os.name == "nt", reason="a script without suffix does not run there")
def test_a_preprocessor_that_does_not_start_is_named(tmp_path, monkeypatch):
    """Also by a worker of dask, which finds its own Python."""
    python = tmp_path / "python"
    python.write_text("#!/bin/sh\necho broken >&2\nexit 2\n")
    python.chmod(0o755)
    monkeypatch.setattr(launch, "_found", lambda: str(python))
    start = launch.Start("", "body", ())
    with pytest.raises(InputError, match=f"^{python}: the preprocessor does not run: "):
        launch.make(start, tmp_path / "body.json")


@pytest.mark.skipif(os.name == "nt", reason="a script without suffix does not run there")
def test_the_file_of_a_killed_preprocessor_is_removed(tmp_path):
    """One that is deep in a factorisation does not hear an interruption in time."""
    python = tmp_path / "python"
    made = f"{tmp_path}/.body.{files._HOST}-$$-0123abcd.vtkhdf"
    python.write_text(f"#!/bin/sh\ntrap '' INT\nread spec\n: >{made}\nexec sleep 60\n")
    python.chmod(0o755)
    own = launch.Preprocessor(launch.Start(str(python), "body", ()))
    made = made.replace("$$", str(own._process.pid))
    thread = threading.Thread(target=own.make, args=(tmp_path / "body.json", lambda _: None))
    thread.start()
    while not os.path.exists(made):
        time.sleep(0.01)
    own.interrupt()
    own.end(0.1)
    thread.join()
    assert not os.path.exists(made)


def test_python_keeps_fenicsx_loaded_and_commands_end_it(
    fenicsx, repository, tmp_path, monkeypatch
):
    """A program that changes a section again and again starts FEniCSx once."""
    monkeypatch.setenv("FENICSX_PYTHON", fenicsx)
    square = repository / "cases/sections/square.toml"

    def section(density):
        pm.Section.from_file(square, {"materials.unit.rho": density}, out=tmp_path)
        return launch._idle[-1]

    first = section(1.0)
    second = section(2.0)
    assert second is first
    assert first.runs()
    first.interrupt()  # from outside: the next call starts another
    assert first.exit_code() != 0
    third = section(3.0)
    assert third.runs()
    monkeypatch.setattr(launch, "_kept", False)  # as in a command
    with launch.preprocessors(lambda _: None):
        pass
    assert launch._idle == []
    assert not third.runs()
