"""Settings that every test shares, in both environments."""

import gc
import os
import signal
import sys
import threading
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

# Small matrices: threads of the linear algebra only get into each other's way.
# Set before NumPy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Commands share the cores with other tests: one that starts a process for each core loads the
# program, or FEniCSx, as often. Tests of several processes ask for them (`--jobs 2`).
os.environ.setdefault("PYTHON_CPU_COUNT", "1")

ROOT = Path(__file__).resolve().parent.parent

try:
    from hypothesis import settings
except ModuleNotFoundError:  # the FE environments have no hypothesis and need none
    pass
else:
    # The same examples on every machine, and no failure because one is slow.
    settings.register_profile("plymotion", derandomize=True, deadline=None)
    settings.load_profile("plymotion")


# Three quarters of the time of the tests without FEniCSx are spent in these files: they start
# programs, compile, kill, or integrate for long. `make check` leaves them to `make test`.
SLOW = {
    "cases": """actuated_beam antenna_panel compiled controlled_arm default_settings design
        docs_followed double_pendulum double_pendulum_shell executors fidelity_command
        fidelity_plan_in_python fidelity_sweep governor judgement judgement_alarms long_output
        many_modes missing_deformation report_page report_strength_page report_viewer run_command
        spinning_plate sweep sweep_interrupted tutorials wind_turbine""",
    "contract": "core_types packages_cli ranks_cli recipes section_cli shell_cli wheel",
    "exchange": "ansys fmu fmu3 fmu_library modes_only stepper",
    "hostile": """changed_inputs current_folder disk_full doubtful_packages edits_and_signals
        exchange_files faults generated_text killed_compilers make_commands make_recovers meshes
        replaced_files signals""",
    "unit": """arena blade blade_files blade_spin blade_stopped case_command compiled_cache
        compiled_leaves_numba_alone new_command preprocessor_task python_api python_examples report
        report_strength section_figures step_loop_contract""",
    "verification": """complex_steps constraints_redundant constraints_singular controllers crane
        cutoff fidelity fidelity_indicators fidelity_omissions fidelity_refusals fidelity_shell_mesh
        modes_of_spinning_beams quasi_static_start segments shipped_body""",
}


class FailuresAtOnce:
    """Writes the name of each failed test when it fails; tools/phases.py looks for these lines."""

    def __init__(self, terminal: Any) -> None:
        self.terminal = terminal

    @pytest.hookimpl(trylast=True)
    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.terminal.write_line(f"\nFAILED {report.nodeid}")


@pytest.hookimpl(trylast=True)
def pytest_configure(config: pytest.Config) -> None:
    """Name failures in the process that writes to the terminal; workers of xdist do not."""
    _hear_ctrl_c()
    terminal = config.pluginmanager.get_plugin("terminalreporter")
    if terminal is not None:
        config.pluginmanager.register(FailuresAtOnce(terminal))


def _hear_ctrl_c() -> None:
    """Take Ctrl-C back that a shell lets a command in the background (`&`) ignore.

    Processes that the tests start and interrupt would ignore it as well.
    """
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    if ignored and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: "list[pytest.Item]") -> None:
    """Mark the tests of slow files; -m "not slow" leaves them out."""
    for item in items:
        name = item.path.stem.removeprefix("test_")
        if name in SLOW.get(item.path.parent.name, "").split():
            item.add_marker(pytest.mark.slow)


def pytest_collection_finish() -> None:
    """Leave modules and tests out of the search for garbage: it takes a twentieth of the time.

    It is made as seldom as in a command (solver/__main__.py); that saves a thirtieth more.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000)


@pytest.fixture(params=["", "without forks"])
def system(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """This system as it is, and with the fallbacks of systems that are not POSIX."""
    if request.param:
        from plymotion.solver.studies import cases
        from plymotion.solver.system import interrupts, platform

        monkeypatch.setenv("PLYMOTION_NO_FORK", "1")  # for the processes that the test starts
        for module in (platform, interrupts, cases):
            monkeypatch.setattr(module, "POSIX", False)
        assert platform.context().get_start_method() == "spawn"
    return str(request.param)


@pytest.fixture(scope="session")
def repository() -> Path:
    """The repository's root folder."""
    return ROOT


@pytest.fixture(scope="session")
def published(repository: Path) -> Callable[[str], dict[str, Any]]:
    """published(name): the table of that name in tests/reference/dynamics."""
    folder = repository / "tests/reference/dynamics"
    return lambda name: tomllib.loads((folder / f"{name}.toml").read_text("utf-8"))


@pytest.fixture(scope="module")
def reference(
    request: pytest.FixtureRequest, published: Callable[[str], dict[str, Any]]
) -> dict[str, Any]:
    """The published table that REFERENCE of the module names."""
    return published(request.module.REFERENCE)


@pytest.fixture(scope="session")
def tools(repository: Path) -> Path:
    """The folder of the repository's tools, importable as top-level modules."""
    folder = repository / "tools"
    if str(folder) not in sys.path:
        sys.path.append(str(folder))
    return folder


@pytest.fixture(scope="session")
def fenicsx() -> str:
    """The Python with FEniCSx that the commands of the light environment find; a skip without."""
    from plymotion.solver.errors import InputError
    from plymotion.solver.workers.interpreter import find_interpreter

    try:
        return find_interpreter()
    except InputError as error:
        pytest.skip(f"needs FEniCSx: {error}")


@pytest.fixture(scope="module")
def one_fenicsx() -> Iterator[None]:
    """One process of FEniCSx for the commands of a module that run in one folder: 1 s for each."""
    from plymotion.solver.workers.launch import kept_preprocessors

    with kept_preprocessors():
        yield
