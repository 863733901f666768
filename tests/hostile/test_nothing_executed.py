"""Files that hold numbers and text start no process and load no code."""

import json

import pytest
from harness.processes import this_python
from samples.package_samples import cantilever
from samples.section_samples import rectangle
from samples.shell_file_samples import plate
from samples.sweep_samples import FORCE, ball

from plymotion.solver.package import write_package
from plymotion.solver.package.section.section_file import write_section
from plymotion.solver.package.shell.shell_file import write_shell

# Tells of each process that is started, and of code and pickled objects from the folder.
WATCHED = """
import json, os, sys
folder, commands = sys.argv[1], json.loads(sys.argv[2])
STARTED = {"subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork",
           "os.forkpty", "pty.spawn", "os.startfile"}
from plymotion.solver.__main__ import main
import plymotion.solver.run.execution, plymotion.solver.commands.sweep
def watch(event, arguments):
    if event in STARTED or event == "pickle.find_class":
        print("FOUND", event, arguments, flush=True)
    elif event == "exec" and arguments[0].co_filename.startswith(folder):
        print("FOUND", event, arguments[0].co_filename, flush=True)
    elif event == "ctypes.dlopen" and folder in str(arguments[0]):
        print("FOUND", event, arguments, flush=True)
sys.addaudithook(watch)
for words in commands:
    code = main(words)
    print("CODE", code, flush=True)
if "--also" in sys.argv:
    import subprocess
    subprocess.run([sys.executable, "--version"])
"""
# Modules that a careless import would find in the folder.
BAIT = ("numpy.py", "h5py.py", "conftest.py", "sitecustomize.py", "controller.py", "case.py")


def _watched(folder, commands, *more):
    return this_python(
        "-P",
        "-c",
        WATCHED,
        folder,
        json.dumps(commands),
        *more,
        cwd=folder,
        more={"PLYMOTION_COMPILED": "0", "PLYMOTION_CACHE": str(folder / "cache")},
    )


@pytest.fixture
def folder(tmp_path):
    for name in BAIT:
        (tmp_path / name).write_text(f"print('FOUND', {name!r})\n")
    return tmp_path


def test_a_case_without_scripts_executes_nothing(folder):
    """Check, run, sweep, twice: the second time results and sweeps are read."""
    file = ball(folder, f"{FORCE} = [0.0, 1.0]", 'histories = ["x"]')
    build = file.parent.parent
    commands = [
        ["check", str(folder / "case.toml"), "--out", str(build)],
        ["run", str(build / "runs/base.json"), "--quiet"],
        ["sweep", str(file), "--quiet", "--no-figures"],
    ]
    done = _watched(folder, [*commands, *commands])
    assert done.stdout.count("CODE 0") == 6, done.stdout + done.stderr
    assert "FOUND" not in done.stdout, done.stdout


def test_files_of_numbers_execute_nothing(folder):
    write_package(folder / "p.vtkhdf", cantilever(n=5, m=2))
    write_section(folder / "s.vtkhdf", rectangle())
    write_shell(folder / "h.vtkhdf", plate())
    commands = [
        ["info", str(folder / "p.vtkhdf")],
        ["section", str(folder / "s.vtkhdf"), "--no-figures"],
        ["shell", str(folder / "h.vtkhdf"), "--no-figures"],
    ]
    done = _watched(folder, commands)
    # The section is a sample without the settings of its analysis: read, and refused then.
    codes = [line for line in done.stdout.splitlines() if line.startswith("CODE")]
    assert codes == ["CODE 0", "CODE 2", "CODE 0"], done.stdout + done.stderr
    assert "FOUND" not in done.stdout, done.stdout


def test_a_process_would_be_found(folder):
    assert "FOUND subprocess.Popen" in _watched(folder, [], "--also").stdout
