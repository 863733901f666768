"""A path to a device that never ends is refused at once."""

import os
import sys

import pytest
from samples.case_samples import HEAD, SOLVER

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.tables.laws import read_columns
from plymotion.solver.inputs.common.text_file import read_toml


def test_devices_are_no_files(tmp_path):
    link = tmp_path / "zero"
    link.symlink_to("/dev/zero")
    with pytest.raises(InputError, match="zero: no such case file"):
        read_toml(link, "case file")
    with pytest.raises(ValueError, match="zero: cannot be read"):
        read_columns(link)


@pytest.mark.skipif(sys.platform == "win32", reason="no such files")
@pytest.mark.parametrize("command", ["run", "sweep", "packages", "import", "blade", "report"])
def test_a_pipe_is_no_file_of_a_command(tmp_path, capsys, command):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    assert main([command, str(pipe)]) == 2
    expected = f"error: {pipe}: expected a file, found a device or a pipe\n"
    assert capsys.readouterr().err == expected


@pytest.mark.skipif(sys.platform == "win32", reason="no such files")
def test_a_pipe_is_no_package(tmp_path, capsys):
    os.mkfifo(tmp_path / "pipe")
    case = tmp_path / "case.toml"
    body = '[bodies.bar]\nkind = "package"\npackage = "pipe"\n'
    case.write_text(HEAD + body + SOLVER.format(t_end=0.1, step=0.01, more=""))
    assert main(["run", str(case), "--out", str(tmp_path / "out")]) == 2
    assert "pipe: no such file" in capsys.readouterr().err
