"""Run the FE tests on every available DOLFINx, two programs at a time, then compare the numbers.

    fe_tests.py [ARGUMENT of pytest ...]
    fe_tests.py --install         install what is missing, run nothing

The distribution's packages and the wheel are the oldest and the newest supported
version. Each one is installed if possible; otherwise the reason is printed. The tests record the
numbers they computed in build/fe-numbers/, one file per version; equal inputs must give equal
numbers (tools/fe_numbers.py).

The tests whose result could depend on rounding (KERNEL_TESTS, and LIGHT_KERNEL_TESTS of the
package checks) run again with every kernel of OpenBLAS that the processor has
(tools/core_types.py). The output of each program is printed when it ends; the summary comes last.
"""

import os
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor

from core_types import Choice, Tests, choice
from core_types import job as job_of_type
from core_types import summary as summary_of_types
from fe_numbers import differences, pairs
from find_fenicsx import (
    APT_INSTALL,
    ROOT,
    SYSTEM_PYTHON,
    Report,
    from_system,
    from_wheel,
    output,
    probe,
    reasons,
    run,
    say,
    usable,
)
from side_by_side import Done, Job, run_all

AT_ONCE = 2  # programs: the cores that CI has
NUMBERS = ROOT / "build" / "fe-numbers"
KERNEL_NUMBERS = ROOT / "build" / "fe-numbers-of-core-types"

# Factorisations, eigenvalues, guards against what is singular or without size, sound packages.
KERNEL_TESTS = (
    *(
        f"tests/fe/test_{name}.py"
        for name in (
            "beam_cantilever",
            "body_recovery",
            "fenicsx",
            "modes_slepc",
            "section_energy",
            "section_guards",
            "shell_flat_nodes",
            "shell_guards",
            "shell_loads",
            "shell_stiffeners",
        )
    ),
    # Processes, strengths, gmsh, groups of cells and text: rounding has no part in the verdict.
    *(
        f"--deselect=tests/fe/test_{file}.py::test_{name}"
        for file, names in {
            "body_recovery": ("package_with_recovery_is_judged_without_fe_code",),
            "fenicsx": (
                "missing_part_is_named",
                "script",
                "unknown_parameter",
                "versions_are_named",
                "what_a_compiled_text_would_read_beyond_is_refused",
            ),
            "section_guards": (
                "a_script",
                "cells_in_two_groups_of_an_old_file",
                "cells_without_group",
                "cubic_cells",
                "group_with",
                "mesh_of_curves_only",
                "mixed_cells",
                "no_group_at_all",
                "no_mesh_in_the_file",
                "no_such_mesh",
                "regions_of_arrays",
                "solid_mesh",
                "surface_in_two_groups",
                "thin_graded_cells_of_the_library_are_no_slivers",
                "two_groups_of_one_name",
            ),
            "shell_guards": ("nodes_of_no_cell", "regions_without_laminate", "script_that_fails"),
        }.items()
        for name in names
    ),
)
LIGHT_KERNEL_TESTS = (
    *(
        f"tests/unit/test_{name}.py"
        for name in (
            "beam_modes",
            "definite",
            "laminate",
            "materials",
            "package_recovery",
            "package_rounding",
            "package_shell",
            "package_validate",
            "reference_checks",
        )
    ),
    "tests/verification/test_second_order_fields.py",
    "tests/verification/test_static_modes.py",
    # Keys, shapes and checksums of files, whatever the numbers are.
    *(
        f"--deselect=tests/unit/test_package_{name}"
        for name in (
            "recovery.py::test_changed_stress_is_noticed_by_the_checksum",
            "recovery.py::test_incomplete_recovery_is_refused",
            "recovery.py::test_unusable_recovery_is_not_written",
            "shell.py::test_a_missing_part_is_named",
            "shell.py::test_an_older_reader_finds_a_body_without_stresses",
            "validate.py::test_every_layout_error_is_reported_not_only_the_first",
        )
    ),
)


def ends() -> list[tuple[str, Report | str]]:
    """(name, report or reason for its absence) for each DOLFINx to test."""
    found: list[tuple[str, Report | str]] = [
        ("distribution", from_system()),
        ("wheel", from_wheel()),
    ]
    if wish := os.environ.get("FENICSX_PYTHON"):
        report = probe(wish)
        known = {entry["python"] for _, entry in found if isinstance(entry, dict)}
        if not usable(report):
            found.append(("FENICSX_PYTHON", f"{wish}: {reasons(report)}"))
        elif report["python"] not in known:
            found.append(("FENICSX_PYTHON", report))
    return found


def has_pytest(python: str) -> bool:
    """True if this interpreter has pytest, after installing it if that is possible."""
    if output([python, "-c", "import pytest"]) is not None:
        return True
    if python == SYSTEM_PYTHON:
        run([APT_INSTALL, "python3-pytest"])
    elif output([python, "-c", "import sys; sys.exit(sys.prefix == sys.base_prefix)"]) is not None:
        run([python, "-m", "pip", "install", "--quiet", "pytest"])
    return output([python, "-c", "import pytest"]) is not None


def main(arguments: list[str]) -> int:
    """Run pytest with each version; exit code 1 if one fails, numbers differ, or none could run."""
    if arguments == ["--install"]:
        for _, report in ends():
            if isinstance(report, dict):
                has_pytest(report["python"])
        return 0
    # Only numbers of this run are compared: an old file could hide a difference.
    for folder in (NUMBERS, KERNEL_NUMBERS):
        shutil.rmtree(folder, ignore_errors=True)
    lines: list[str] = []
    ran: list[Report] = []
    jobs: list[Job] = []
    for name, report in ends():
        if isinstance(report, str):
            lines.append(f"{name}: SKIPPED, {report}")
            continue
        title = f"DOLFINx {report['dolfinx']} ({name}, {report['python']})"
        if not has_pytest(report["python"]):
            lines.append(f"{title}: SKIPPED, it has no pytest and none could be installed")
            continue
        ran.append(report)
        jobs.append(Job(title, whole(report, arguments, len(ran) == 1)))
    chosen = [] if arguments else core_types(ran)
    # A core type uses the forms that the whole run with the same DOLFINx compiled: two processes
    # that compile one form wait for each other, and not for long. The light tests use none.
    whole_runs = list(jobs)
    before = [None, *whole_runs]
    for (tests, types), after in zip(chosen, before, strict=False):
        jobs += [job_of_type(tests, name, after) for name in types.types]
    results = run_all(
        jobs,
        AT_ONCE,
        ended=lambda done: show(done, done.job in whole_runs),
        wrote=name_failure,
        patience=5.0,
    )
    for done in results[: len(ran)]:
        verdict = "passed" if done.code == 0 else "FAILED"
        lines.append(f"{done.job.title}: {verdict} in {done.seconds:.0f} s")
    failed = compare(len(ran), lines) or not ran or any(done.code for done in results)
    if chosen:
        failed = compare_core_types(chosen, results[len(ran) :], lines) or failed
    print()
    for line in lines:
        say(line)
    return int(failed)


def whole(report: Report, arguments: list[str], first: bool) -> tuple[str, ...]:
    """The command of the FE tests; two of them at once need caches of their own.

    Tests with the mark `one_end` test no call of DOLFINx, PETSc or gmsh that others do not test:
    only the first run has them.
    """
    cache = f"cache_dir={ROOT / 'build' / 'pytest-cache'}-{report['dolfinx']}"
    options = ["-q", "--durations=10", "-o", cache]
    if not first:
        options += ["-m", "not one_end"]
    return (report["python"], "-m", "pytest", *options, "tests/fe", *arguments)


def show(done: Done, always: bool) -> None:
    """Print the output of a run, if it failed or always."""
    if always or done.code:
        print(f"\n== FE tests on {done.job.title}\n{done.output}", end="", flush=True)


def name_failure(job: Job, line: str) -> None:
    """Print the line with which a test says that it failed (tests/conftest.py)."""
    if line.startswith("FAILED tests/") and " - " not in line:
        print(f"{line} on {job.title}", flush=True)


def compare(ran: int, summary: list[str]) -> bool:
    """Compare the recorded numbers of all versions; True if any differ."""
    files = sorted(NUMBERS.glob("*.json"))
    if ran < 2:
        summary.append("numbers between versions: NOT COMPARED, fewer than two versions ran")
        return False
    if len(files) != ran:
        summary.append(f"numbers between versions: FAILED, {ran} ran but {len(files)} recorded")
        return True
    lines = [line for first, second in pairs(files) for line in differences(first, second)]
    for line in lines:
        print(line, file=sys.stderr)
    result = f"FAILED, {len(lines)} differences" if lines else "equal"
    summary.append(f"numbers between {', '.join(file.stem for file in files)}: {result}")
    return bool(lines)


def core_types(ran: list[Report]) -> list[tuple[Tests, Choice]]:
    """The tests of kernels and the core types to run them with: light ones, then each DOLFINx."""
    every = [Tests("light environment", sys.executable, "scipy.linalg", LIGHT_KERNEL_TESTS)]
    every += [
        Tests(
            f"DOLFINx {report['dolfinx']}",
            report["python"],
            "plymotion.preprocess.fenicsx",
            KERNEL_TESTS,
            KERNEL_NUMBERS,
        )
        for report in ran
    ]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        return list(zip(every, pool.map(choice, every), strict=True))


def compare_core_types(
    chosen: list[tuple[Tests, Choice]], results: list[Done], summary: list[str]
) -> bool:
    """Compare the numbers of the core types with those of the whole runs; True if any differ."""
    left = list(results)
    for tests, types in chosen:
        own, left = left[: len(types.types)], left[len(types.types) :]
        summary.append(summary_of_types(tests.title, types, own))
    files = sorted(KERNEL_NUMBERS.glob("*/*.json"))
    found = [line for file in files for line in differences(NUMBERS / file.name, file, common=True)]
    for line in found:
        print(line, file=sys.stderr)
    if files:
        result = f"FAILED, {len(found)} differences" if found else "equal"
        summary.append(f"numbers between core types: {result}")
    seconds = sum(done.seconds for done in results)
    summary.append(f"runs with core types took {seconds:.0f} s, {AT_ONCE} at a time")
    return bool(found)


if __name__ == "__main__":
    os.chdir(ROOT)
    os.environ["PYTHONPATH"] = str(ROOT)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
