"""Output that is closed, full, or not read to its end: the exit code tells what was done."""

import os
import subprocess
import sys

import pytest
from harness.hostile_profile import WAIT_S, count
from samples.sweep_samples import FORCE, ball

from plymotion.solver.results import read_result

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the shell of other systems")


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    """A case that is checked."""
    return ball(tmp_path_factory.mktemp("streams"), f"{FORCE} = [0.0, 1.0]").parent.parent


def _shell(build, command, redirected):
    words = f'"{sys.executable}" -m plymotion {command} {redirected}'
    return subprocess.run(
        ["bash", "-c", words],
        cwd=build,
        env=os.environ | {"PLYMOTION_COMPILED": "0"},
        capture_output=True,
        text=True,
        timeout=WAIT_S,
    )


@pytest.mark.parametrize("redirected", ["2>&-", "<&- >&- 2>&-"])
def test_closed_streams(build, redirected):
    """Files of the run must not take the numbers of the streams: messages would go into them."""
    done = _shell(build, "run runs/base.json", redirected)
    assert done.returncode == 0
    assert read_result(build / "base/result.vtkhdf").t[-1] == 1.0
    count(f"run: streams closed, {redirected}", "done")


@pytest.mark.parametrize("command", ["check ../case.toml", "run runs/base.json --quiet"])
def test_full_output(build, command):
    done = _shell(build, command, "> /dev/full")
    assert done.returncode == 2
    assert done.stderr == "error: standard output: No space left on device\n"
    count(f"{command.split()[0]}: output to a full disk", "refused")


def test_output_without_a_reader(build):
    """Neither words nor a claim that all is done."""
    done = _shell(build, "check --reference", "| true; exit ${PIPESTATUS[0]}")
    assert (done.returncode, done.stderr) == (141, "")
    count("check: output that nobody reads", "done")


@pytest.mark.parametrize("command", ["info", "check", "run", "import -o x.vtkhdf"])
def test_control_characters_of_names_do_not_reach_the_terminal(build, command):
    """They would set the title of the window, or delete what was written."""
    done = _shell(build, f"{command} $'a\\x1b]0;title\\x07\\x1b[2J\\x9b2J.toml'", "")
    assert done.returncode == 2
    assert not {"\x1b", "\x07", "\x9b"} & {*done.stdout, *done.stderr}
    assert r"a\x1b]0;title\x07" in done.stderr
