"""Scripts of meshes are refused on request, and files without scripts execute nothing."""

import pytest

from plymotion.solver.__main__ import main


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
