"""The command line: check, compile, packages, run, modes, report, section, shell, sweep, ..."""

if __name__ == "__main__":
    from .interrupts import end_at_once

    end_at_once()

import argparse
import atexit
import contextlib
import gc
import os
import sys
from collections.abc import Iterator
from pathlib import Path

from plymotion import __version__

from .commands.arguments import (
    COMMAND,
    CommandParser,
    add_case_options,
    add_figures,
    add_no_scripts,
)
from .commands.blade.options import add_blade_command
from .commands.chart.options import add_chart_command
from .commands.exchange.options import add_exchange_commands
from .commands.modes.options import add_modes_command
from .commands.new.options import add_new_command
from .commands.packages.options import add_packages_command
from .commands.plan.options import add_plan_command
from .commands.run.options import add_run_command
from .commands.section.options import add_section_command
from .commands.shell.options import add_shell_command
from .commands.solid.options import add_solid_command
from .commands.streams import complete, full_output, no_reader
from .commands.sweep.options import add_merge_command, add_sweep_command
from .errors import InputError, PackageError, counted
from .inputs.case.file import CASE_FILE
from .inputs.scripts import scripts
from .interrupts import (
    INTERRUPTED,
    ending_words,
    exit_code,
    heard,
    ignore,
    of_a_signal,
    starting,
)
from .package.common.replaceable import named_by_user

EPILOG = """\
examples:
  plymotion new robot-arm                 a commented case, robot-arm/case.toml
  plymotion robot-arm/case.toml           check, bodies, runs: build/robot-arm/report.html
  plymotion run --help                    its options: --run, --out, --jobs, --coarse, ...

exit code: 0 done; 2 something is wrong with the input; 3 a run or a member of a sweep ended early
or is invalid, see the help of the command; 70 a defect of the program; 130, 143, 129 ended by
Ctrl-C, TERM or HUP.
"""


def main(arguments: list[str] | None = None) -> int:
    """Run one command; return the exit code.

    0 done; 2 wrong input, or errors found by `validate`; 3 a run, or members of a sweep,
    ended early and their results up to that time are kept, or the findings of a run call its
    results invalid; 70 a defect of the program; 130, 143, 129 ended by Ctrl-C, TERM or HUP, results
    are kept; 141 the reader of the output has gone.
    """
    if arguments is None:
        # Looking for garbage takes 0.04 s while modules are loaded, 0.03 s at the end.
        gc.set_threshold(50_000)
        atexit.register(gc.freeze)
        # Pydantic would search all installed packages for plugins: 0.02 s.
        os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
        complete()
    words = sys.argv[1:] if arguments is None else arguments
    # "plymotion solver sweep" is "plymotion sweep", as is "python -m plymotion.solver sweep".
    if words[:1] == ["solver"]:
        words = words[1:]
    known = parser()
    # "plymotion case.toml" is "plymotion run case.toml", unless a command has the folder's name.
    if words and words[0] not in known.commands() and _is_case(words[0]):
        words = ["run", *words]
    options = known.parsed(words)
    try:
        with heard():
            code = exit_code(_guarded(options))
    except KeyboardInterrupt:  # while a message was printed, or between two handlers
        code = exit_code(_interrupted())
    if arguments is None:
        ignore()  # all is done: a signal while Python ends would only be a traceback
    return code


def _is_case(word: str) -> bool:
    return word.endswith(".toml") or os.path.isfile(f"{word}/{CASE_FILE}")


def _guarded(options: argparse.Namespace) -> int:
    """Run a command; turn what it raises into a message and an exit code."""
    try:
        with (
            scripts(allowed=not getattr(options, "no_scripts", False)),
            named_by_user(_paths(options)),
        ):
            code = int(options.command(options))
            sys.stdout.flush()  # a full disk or a closed pipe is told here
            return code
    except (InputError, PackageError) as error:
        if of_a_signal(error):
            return _interrupted()
        for line in str(error).splitlines():
            print(f"error: {line}", file=sys.stderr)
        return 2
    except BrokenPipeError:
        return no_reader()
    except OSError as error:
        ended = full_output(error)
        if ended is not None:
            return ended
        where = f"{error.filename}: " if error.filename else ""
        print(f"error: {where}{error.strerror or error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return _interrupted()
    except Exception as error:
        if of_a_signal(error):
            return _interrupted()
        from .commands.defect import DEFECT, report

        print(f"error: {report(error)}", file=sys.stderr)
        return DEFECT


def _paths(options: argparse.Namespace) -> list[Path]:
    """Return all paths of a command line; of build/CASE/runs/RUN.json also build/CASE."""
    values = [v for value in vars(options).values() for v in _listed(value) if isinstance(v, Path)]
    return [*values, *(path.parent.parent for path in values if path.suffix == ".json")]


def _listed(value: object) -> list[object]:
    return value if isinstance(value, list) else [value]


def _interrupted() -> int:
    print(ending_words(), file=sys.stderr)
    return INTERRUPTED


def parser() -> CommandParser:
    """Return the parser of all commands."""
    parser = CommandParser(
        prog="plymotion",
        usage="plymotion CASE.toml | plymotion COMMAND ...",
        description="Flexible multibody dynamics with laminated members.\n"
        "`plymotion CASE.toml` goes from a case file to its report; commands do parts of it.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"plymotion {__version__}")
    commands = parser.add_subparsers(required=True, metavar=COMMAND, prog="plymotion")

    # In the order in which a user meets them: a case, its parts, packages, many runs, the rest.
    add_new_command(commands, _new)
    check = commands.add_parser(
        "check", help="check a case file; with --out, write the input of the other commands"
    )
    check.add_argument("case", type=Path, nargs="?", metavar="CASE", help="CASE.toml")
    check.add_argument(
        "--out", type=Path, metavar="DIR", help="write case.json, bodies/, runs/, sweeps/ there"
    )
    add_case_options(check)
    add_no_scripts(check)
    check.add_argument("--reference", action="store_true", help="print docs/case-reference.md")
    check.set_defaults(command=_check)
    add_run_command(commands, _run)
    report = commands.add_parser("report", help="write report.html and the table of a case")
    report.add_argument("folder", type=Path, metavar="DIR", help="folder of a case, build/CASE")
    add_figures(report)
    report.add_argument(
        "--glb", action="store_true", help="also write RUN/motion.glb, for Blender and slides"
    )
    report.add_argument(
        "--vtk",
        action="store_true",
        help="also write RUN/motion.vtkhdf, for ParaView: surfaces with results in their cells",
    )
    report.set_defaults(command=_report)
    add_modes_command(commands, _modes)
    add_plan_command(commands, _plan)
    add_chart_command(commands, _chart)
    add_section_command(commands, _section)
    add_shell_command(commands, _shell)
    add_solid_command(commands, _solid)
    add_blade_command(commands, _blade)
    add_exchange_commands(commands, _import, _export)
    experimental = commands.add_parser(
        "experimental", help="make a modal package from measured modes (docs/modes.md)"
    )
    experimental.add_argument(
        "file", type=Path, metavar="FILE", help="nodes, modes and places of a test, TOML"
    )
    experimental.add_argument(
        "--out", type=Path, required=True, metavar="PACKAGE", help="PACKAGE.vtkhdf"
    )
    experimental.set_defaults(command=_experimental)
    info = commands.add_parser("info", help="show the content of a modal package")
    info.add_argument("package", type=Path, metavar="PACKAGE", help="PACKAGE.vtkhdf")
    info.set_defaults(command=_info)
    validate = commands.add_parser("validate", help="check modal packages against docs/format.md")
    validate.add_argument("package", type=Path, nargs="+", metavar="PACKAGE", help="PACKAGE.vtkhdf")
    validate.set_defaults(command=_validate)
    add_packages_command(commands, _packages)
    add_sweep_command(commands, _sweep)
    add_merge_command(commands, _merge)
    ahead = commands.add_parser("compile", help="compile before the first run")
    ahead.add_argument(
        "--all",
        action="store_true",
        help="also that of generalized-alpha, and what FEniCSx needs of bodies",
    )
    ahead.set_defaults(command=_compile)
    completion = commands.add_parser(
        "completion", help="print the completion of commands and options for a shell"
    )
    completion.add_argument("shell", choices=["bash", "zsh"], help="see docs/runs.md")
    completion.set_defaults(command=_completion)
    parser.describe_commands()
    return parser


def _check(options: argparse.Namespace) -> int:
    from .inputs.case import load_case
    from .inputs.case.reference import reference_page
    from .inputs.case.specs import write_case

    if options.reference:
        print(reference_page(), end="")
        return 0
    if options.case is None:
        raise InputError("check: no case file given; expected CASE.toml")
    case = load_case(options.case, coarse=options.coarse)
    if options.out is None:
        print(f"{options.case}: {counted(len(case.runs), 'run')}, no errors")
    else:
        write_case(case, options.out, options.packages)
    return 0


def _new(options: argparse.Namespace) -> int:
    from .commands.new.command import run_new

    return run_new(options)


def _completion(options: argparse.Namespace) -> int:
    from .commands.completion import completion

    print(completion(parser(), options.shell))
    return 0


@contextlib.contextmanager
def _importing() -> Iterator[None]:
    """Imports leave no garbage worth the time of looking for it."""
    gc.disable()
    try:
        with starting():
            yield
    finally:
        gc.enable()


def _run(options: argparse.Namespace) -> int:
    if any(file.suffix == ".toml" or file.is_dir() for file in options.files):
        from .commands.cases.command import run_case

        return run_case(options)
    with _importing():
        from .commands.run.command import run_runs

    return run_runs(options)


def _plan(options: argparse.Namespace) -> int:
    from .commands.plan.command import run_plan

    return run_plan(options)


def _chart(options: argparse.Namespace) -> int:
    from .commands.chart.command import run_chart

    return run_chart(options)


def _compile(options: argparse.Namespace) -> int:
    from .commands.compile import compile_ahead

    print(compile_ahead(everything=options.all), flush=True)
    if options.all:
        from .commands.fenicsx_side.launch import compile_forms

        print(compile_forms())
    return 0


def _report(options: argparse.Namespace) -> int:
    from .commands.cases.report import report_case

    print(report_case(options.folder, figures=options.figures, glb=options.glb, vtk=options.vtk))
    return 0


def _info(options: argparse.Namespace) -> int:
    from .package.body.io import read_package

    package = read_package(options.package)
    print(f"{package.body}: {package.nodes_B.shape[0]} nodes, {package.n_mode} modes")
    print(f"  reference condition {package.reference_condition}")
    print(f"  mass {package.invariants.mass:.6g} kg, inertia {package.invariants.mass_form}")
    labels = package.mode_labels or package.mode_kinds
    for label, frequency in zip(labels, package.frequencies, strict=True):
        print(f"  {label:24s} {frequency:12.5g} rad/s {frequency / 6.283185307179586:12.5g} Hz")
    for interface in package.interfaces:
        x, y, z = interface.position_B
        print(f"  interface {interface.name:12s} at ({x:.6g}, {y:.6g}, {z:.6g}) m")
    return 0


def _validate(options: argparse.Namespace) -> int:
    from .package import validate

    failed = 0
    for path in options.package:
        findings = validate(path)
        for item in findings:
            print(f"{path}: {item.level}: {item.dataset}: {item.message}")
        if any(item.level == "error" for item in findings):
            failed = 2
        else:
            print(f"{path}: valid")
    return failed


def _experimental(options: argparse.Namespace) -> int:
    from .commands.measured_modes import experimental_package, load_measurement, write_measured

    return write_measured(
        options.out, experimental_package(load_measurement(options.file)), options.file
    )


def _modes(options: argparse.Namespace) -> int:
    with _importing():
        from .commands.modes.command import run_modes

    return run_modes(options)


def _import(options: argparse.Namespace) -> int:
    from .commands.exchange.command import run_import

    return run_import(options)


def _export(options: argparse.Namespace) -> int:
    from .commands.exchange.command import run_export

    return run_export(options)


def _blade(options: argparse.Namespace) -> int:
    from .commands.blade.command import run_blade

    return run_blade(options)


def _section(options: argparse.Namespace) -> int:
    from .commands.section.command import run_section

    return run_section(options)


def _solid(options: argparse.Namespace) -> int:
    from .commands.solid.command import run_solid

    return run_solid(options)


def _shell(options: argparse.Namespace) -> int:
    from .commands.shell.command import run_shell

    return run_shell(options)


def _packages(options: argparse.Namespace) -> int:
    from .commands.packages.command import run_packages

    return run_packages(options)


def _sweep(options: argparse.Namespace) -> int:
    with _importing():
        from .commands.sweep.command import run_sweep

    return run_sweep(options)


def _merge(options: argparse.Namespace) -> int:
    with _importing():
        from .commands.sweep.command import run_merge

    return run_merge(options)


if __name__ == "__main__":
    sys.exit(main())
