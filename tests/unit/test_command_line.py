"""The command line itself: entry points, nearest commands and options, completion."""

import math
import os
import subprocess
import sys
from pathlib import Path

import pytest
from harness.processes import this_python

import plymotion
from plymotion.solver.__main__ import main, parser
from plymotion.solver.commands.setup import completion


@pytest.mark.parametrize("module", ["plymotion", "plymotion.solver"])
def test_the_version(module: str) -> None:
    run = this_python("-m", module, "--version")
    assert (run.returncode, run.stdout) == (0, f"plymotion {plymotion.__version__}\n")


@pytest.mark.parametrize(
    ("module", "own", "kept"),
    [
        ("plymotion", {}, "1"),
        ("plymotion.solver", {"OPENBLAS_NUM_THREADS": "3"}, "3"),
        ("plymotion", {"OMP_NUM_THREADS": "2"}, "None"),
        ("", {}, "None"),  # Python that imports the package keeps its threads
    ],
)
def test_a_command_has_one_thread_unless_the_user_says_more(
    module: str, own: dict[str, str], kept: str
) -> None:
    lines = "import atexit, os, runpy, sys, plymotion\n"
    lines += "atexit.register(lambda: print(os.environ.get('OPENBLAS_NUM_THREADS')))\n"
    if module:
        lines += f"sys.argv[1:] = ['--version']\nrunpy.run_module({module!r}, run_name='__main__')"
    env = {k: v for k, v in os.environ.items() if not k.endswith("_NUM_THREADS")} | own
    run = this_python("-c", lines, env=env)
    assert run.returncode == 0, run.stderr
    assert run.stdout.split()[-1] == kept


def test_a_command_ends_without_freeing_its_objects_one_by_one() -> None:
    lines = "import atexit, runpy, sys\nclass Last:\n    def __del__(self): print('freed')\n"
    lines += "last, sys.argv[1:] = Last(), ['materials', 'no such material']\n"
    lines += "import plymotion.solver.__main__\n"
    lines += "begin = atexit.register\n"
    lines += "atexit.register = lambda *a: (begin(*a), begin(print, 'all else'))\n"
    lines += "runpy.run_module('plymotion', run_name='__main__')"
    run = this_python("-c", lines)
    assert (run.returncode, run.stdout) == (2, "all else\n"), run.stderr


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["sweeep"], "error: sweeep: no such command; did you mean 'sweep'?\nCommands: "),
        (["zzz"], "error: zzz: no such command\nCommands: "),
        (["arm"], "error: arm: no such command; did you mean plymotion run arm.toml?\n"),
        ([], "error: expected CASE.toml or a command\nCommands: blade, "),
        (["/"], "error: /: no case; expected CASE.toml, a folder with case.toml, or a command\n"),
        (["new"], "required: {arm,robot-arm,panel,bracket,pendulum,blade,shaft}"),
        (["run", "a.json", "--quite"], "--quite: unknown argument; did you mean '--quiet'?"),
        (["arm.toml", "--coase"], "--coase: unknown argument; did you mean '--coarse'?"),
        (["arm.toml", "--cores", "2"], "--cores: unknown argument; did you mean '--jobs'?"),
        (["check", "arm.toml", "--run", "a"], "--run: unknown argument\n"),
        (["report", "here", "there"], "there: unknown argument"),
    ],
)
def test_the_nearest_word_is_proposed(
    words: list[str],
    message: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("arm.toml").touch()
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    assert message in capsys.readouterr().err


def test_help_is_as_wide_as_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    longest = []
    for columns in ("50", "120", "wide"):
        monkeypatch.setenv("COLUMNS", columns)
        text = parser("run").commands()["run"].format_help()
        lines = text.partition("options:")[2].partition("with a case")[0].splitlines()
        longest.append(max(len(line) for line in lines))
    assert longest[0] <= 48 < longest[1] <= 118
    assert longest[2] > 48  # that of the terminal, or 78


def test_completion_without_shtab_says_what_is_missing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["completion", "bash"]) == 2
    assert "pip install shtab" in capsys.readouterr().err


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_completion_has_commands_and_options(shell: str) -> None:
    pytest.importorskip("shtab")
    script = completion(parser(), shell)
    assert "--allow-python" in script
    assert "--at" in script
    assert all(name in script for name in ("sweep", "modes", "info"))


def test_bash_completes_commands_and_files(tmp_path: Path) -> None:
    """What a press of the tab key proposes, in a real bash."""
    pytest.importorskip("shtab")
    (tmp_path / "script.bash").write_text(completion(parser(), "bash"))
    (tmp_path / "arm.toml").touch()
    lines = """
    source ./script.bash
    propose() {
        COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=()
        local function=$(complete -p plymotion | sed 's/.*-F \\([^ ]*\\).*/\\1/')
        $function plymotion "${!#}" "${COMP_WORDS[$(($# - 2))]}"
        echo "${COMPREPLY[@]}"
    }
    propose plymotion swe
    propose plymotion run --coa
    propose plymotion run ar
    """
    run = subprocess.run(["bash", "-c", lines], cwd=tmp_path, capture_output=True, text=True)
    assert run.stdout.split("\n") == ["sweep", "--coarse", "arm.toml", ""], run.stderr


def test_smoke_finds_another_motion(repository: Path, tools: Path) -> None:
    """What `make smoke` compares: the run as it is, and with a slider elsewhere."""
    import smoke

    signals = {"crank_angle": {"final": 7.5}, "slider_x": {"final": 0.0}}
    summary = {"completed": True, "t_end": 0.06, "warnings": [], "signals": signals}
    summary["signals"]["slider_x"]["final"] = 0.15 * math.cos(7.5) + math.sqrt(
        0.09 - (0.15 * math.sin(7.5)) ** 2
    )
    assert smoke.problems(summary) == []
    summary["signals"]["slider_x"]["final"] += 1e-4
    summary["warnings"] = [{"code": "energy-drift", "message": "-"}]
    assert [found.split()[0] for found in smoke.problems(summary)] == ["energy-drift:", "slider_x"]


@pytest.mark.parametrize(
    ("word", "what"),
    [("nwe", "command; did you mean 'new'?"), ("arm.tml", "file"), ("a/b", "file")],
)
def test_what_is_no_command_may_be_a_missing_file(word, what, capsys):
    with pytest.raises(SystemExit) as ended:
        main([word])
    assert ended.value.code == 2
    assert capsys.readouterr().err.startswith(f"error: {word}: no such {what}\nCommands: blade, ")


@pytest.mark.parametrize("option", [["--fresh"], ["--jobs", "2"]])
def test_merging_computes_nothing(option, capsys):
    assert main(["sweep", "s.json", "--merge", *option]) == 2
    message = f"{option[0]}: expected without --merge, which computes nothing"
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("option", ["--json", "--no-check"])
def test_a_chart_is_no_answer(option, capsys):
    assert main(["plan", "case.toml", "--chart", option]) == 2
    assert f"{option}: expected without --chart" in capsys.readouterr().err
