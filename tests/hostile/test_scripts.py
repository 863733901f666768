"""Scripts of meshes are refused on request, and files without scripts execute nothing."""

import pytest

from plymotion.solver.__main__ import main, parser
from plymotion.solver.inputs.common.mesh_files import scripts
from plymotion.solver.workers.executors import Local
from plymotion.solver.workers.launch import start_of


@pytest.mark.parametrize("command", ["section", "shell"])
def test_scripts_are_refused_on_request(repository, tmp_path, capsys, command):
    name = {"section": "sections/pendulum-arm.toml", "shell": "shells/plate-cantilever.toml"}
    file = tmp_path / "d.toml"
    text = (repository / "cases" / name[command]).read_text()
    script = tmp_path / "own.geo"
    script.write_text('SystemCall "touch P";\n')
    if command == "section":
        head, _, rest = text.partition("[mesh]\n")
        table = rest.partition("\n[")
        text = f'{head}[mesh]\nfile = "own.geo"\n\n[{table[2]}'
    else:
        old = next(line for line in text.splitlines() if line.startswith("file = "))
        text = text.replace(old, 'file = "own.geo"')
    file.write_text(text)
    words = [command, str(file), "--check", "--out", str(tmp_path / "o"), "--no-scripts"]
    assert main(words) == 2
    told = capsys.readouterr()
    shown = told.err + told.out
    assert 'mesh.file = "own.geo": expected no script with --no-scripts' in shown
    assert not (tmp_path / "P").exists()


def test_shapes_of_the_library_are_no_scripts_of_the_user(repository, tmp_path):
    file = repository / "cases/sections/square.toml"
    assert main(["section", str(file), "--check", "--out", str(tmp_path), "--no-scripts"]) == 0


BUILDING = ["check", "run", "plan", "modes", "packages", "section", "shell", "export"]


@pytest.mark.parametrize("command", BUILDING)
def test_every_command_that_builds_can_refuse_scripts(command):
    known = parser().commands()[command]
    assert "--no-scripts" in known._option_string_actions


@pytest.mark.parametrize("command", [["run"], ["plan"], ["plan", "--chart"], ["modes"], ["check"]])
def test_the_script_of_a_shell_of_a_case_is_refused(repository, tmp_path, capsys, command):
    assert main(["new", "panel", str(tmp_path / "panel")]) == 0
    script = tmp_path / "panel/panel.geo"
    script.write_text(f'SystemCall "touch {tmp_path}/STRUCK";\n{script.read_text()}')
    case = str(tmp_path / "panel/case.toml")
    capsys.readouterr()
    assert main([*command, case, "--out", str(tmp_path / "out"), "--no-scripts"]) == 2
    assert "expected no script with --no-scripts" in capsys.readouterr().err
    assert not (tmp_path / "STRUCK").exists()


def test_the_preprocessor_is_told():
    """Specifications that `check` has not written may name scripts: `packages` only reads them."""
    place = Local(1, threads=True)
    with scripts(allowed=False):
        assert "--no-scripts" in start_of("body", [], place).options
    assert "--no-scripts" not in start_of("body", [], place).options
