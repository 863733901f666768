"""Command line of the preprocessor: `python -m plymotion.preprocess body SPEC.json ...`."""

import argparse
import atexit
import gc
import sys
from collections.abc import Sequence
from pathlib import Path

from ..solver.errors import escape_control_characters
from ..solver.interrupts import INTERRUPTED, exit_code, heard
from ..solver.package.common.shares import shard
from .python_script import scripts

BODY_EPILOG = """\
Writes the modal package DIR/SPEC.vtkhdf for each SPEC.json. A package whose stored
inputs (specification, preprocessor sources, format version) are unchanged is not
written again, so make does not repeat runs that read it. SPEC `-` alone reads
names from standard input and builds each one immediately.

exit code: 0 all packages are up to date; 2 a body could not be built (the others
were built); 130 interrupted.
"""
SECTION_EPILOG = """\
Writes the section file SPEC.vtkhdf for each SPEC.json. A file whose stored inputs
(specification, options, preprocessor sources, format version) are unchanged is
not written again. @LIST reads arguments from the lines of the file LIST. SPEC `-`
alone reads names from standard input and processes each one immediately.

{ranks}

exit code: 0 all files are up to date; 2 a section could not be analysed (the others
were analysed); 130 interrupted.
"""
SHELL_EPILOG = """\
Writes the shell file SPEC.vtkhdf for each SPEC.json: displacements, resultants and
reactions of its load cases, natural modes. A file whose stored inputs
(specification, preprocessor sources, format version) are unchanged is not written
again. SPEC `-` alone reads names from standard input and processes each one
immediately. `mpirun -n N python -m plymotion.preprocess shell ...` analyses one
shell after the other with all ranks, each with its own cells; rank 0 writes and
prints.

exit code: 0 all files are up to date; 2 a shell could not be analysed (the others
were analysed); 130 interrupted.
"""
RANKS_EPILOG = """\
`mpirun -n N python -m plymotion.preprocess section ...` analyses one section
after the other with all ranks, each with its own cells; rank 0 writes and prints."""
POOL_EPILOG = """\
Start this command with
    mpirun -n N python -m mpi4py.futures -m plymotion.preprocess section-batch ...
Rank 0 distributes the sections and prints. Every other rank analyses one section
at a time and keeps meshes and factorisations for the next."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code."""
    options = _parser().parse_args(arguments)
    with heard():
        return exit_code(_guarded(options))


def _guarded(options: argparse.Namespace) -> int:
    """Run a command; turn what it raises into a message and an exit code."""
    try:
        with scripts(refused=options.no_scripts):
            return int(options.run(options))
    except OSError as error:
        print(f"error: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        return 2
    except ImportError as error:
        if not type(error).__module__.startswith("plymotion."):
            raise
        print(f"error: {error}", file=sys.stderr)  # it states what is missing
        return 2
    except KeyboardInterrupt:
        print("interrupted: files finished before are kept", file=sys.stderr)
        return INTERRUPTED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m plymotion.preprocess",
        description="Build modal packages from laminates, meshes and materials (needs FEniCSx).",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, text in (("body", "bodies"), ("solid", "solids that are analysed alone")):
        body = commands.add_parser(
            name,
            help=f"build the modal packages of {text}",
            description=f"Build the modal packages of {text}: modes, inertia.",
            epilog=BODY_EPILOG,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        _add_specs(body, "specification of one body, as `plymotion check` or `solid` writes it")
        body.add_argument(
            "--out-dir", type=Path, metavar="DIR", help="folder of the packages (default: SPEC's)"
        )
        body.add_argument("--json", action="store_true", help="print one line of JSON per body")
        body.set_defaults(run=_body)
    for name, text, ranks in (
        ("section", "analyse cross-sections", RANKS_EPILOG),
        ("section-batch", "analyse many cross-sections over the ranks of an MPI job", POOL_EPILOG),
    ):
        section = commands.add_parser(
            name,
            help=text,
            description=f"{text[0].upper()}{text[1:]}: stiffness, mass, recovery of stresses.",
            epilog=SECTION_EPILOG.format(ranks=ranks),
            formatter_class=argparse.RawDescriptionHelpFormatter,
            fromfile_prefix_chars="@",
        )
        _add_specs(section, "specification of one section, as `plymotion section` writes it")
        _add_section_options(section)
        section.set_defaults(run=_section if name == "section" else _section_batch)
    _add_shell(commands)
    ahead = commands.add_parser(
        "compile",
        help="compile what DOLFINx needs, ahead of the first analysis",
        description="Compile what sections, shells and solids need, ahead of their first analysis.",
    )
    ahead.set_defaults(run=_compile, no_scripts=False)
    return parser


def _add_shell(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    shell = commands.add_parser(
        "shell",
        help="analyse laminated plates and shells",
        description="Analyse laminated plates and shells: load cases and natural modes.",
        epilog=SHELL_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        fromfile_prefix_chars="@",
    )
    _add_specs(shell, "specification of one shell, as `plymotion shell` writes it")
    place = shell.add_mutually_exclusive_group()
    place.add_argument("--out", type=Path, metavar="FILE", help="name of the file, for one SPEC")
    place.add_argument(
        "--out-dir", type=Path, metavar="DIR", help="folder of the files (default: beside SPEC)"
    )
    _add_verify(shell, "energies and frequencies")
    shell.add_argument("--json", action="store_true", help="print one line of JSON per shell")
    shell.set_defaults(run=_shell)


def _add_specs(parser: argparse.ArgumentParser, text: str) -> None:
    parser.add_argument("specs", nargs="+", type=Path, metavar="SPEC.json", help=text)
    parser.add_argument(
        "--force", action="store_true", help="build all files, also those that are up to date"
    )
    parser.add_argument(
        "--no-scripts", action="store_true", help="refuse mesh scripts of the user (.geo, .py)"
    )


def _add_section_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--out-dir", type=Path, metavar="DIR", help="folder of the files (default: beside SPEC)"
    )
    parser.add_argument(
        "--accuracy",
        type=float,
        metavar="A",
        help="refine until the estimated error of K, scaled by sqrt(Kii Kjj), is below A",
    )
    parser.add_argument(
        "--no-estimate", action="store_true", help="skip the error estimate (faster)"
    )
    _add_verify(parser, "K")
    parser.add_argument(
        "--shard", type=shard, default=(1, 1), metavar="k/N", help="only the k-th of N shares"
    )
    parser.add_argument("--json", action="store_true", help="print one line of JSON per section")


def _add_verify(parser: argparse.ArgumentParser, what: str) -> None:
    text = f"compute {what} by a second method as well, and compare"
    parser.add_argument("--verify", action="store_true", help=text)


def _body(options: argparse.Namespace) -> int:
    from .body_packages import build_bodies  # here, so that --help needs no HDF5

    return build_bodies(options)


def _section(options: argparse.Namespace) -> int:
    from .section.analysis.batch import run_sections

    return run_sections(options, pool=False)


def _shell(options: argparse.Namespace) -> int:
    from .shell.analyses.batch import run_shells

    if options.out and (len(options.specs) > 1 or options.specs == [Path("-")]):
        print("error: --out: expected one SPEC.json; several need --out-dir", file=sys.stderr)
        return 2
    return run_shells(options)


def _compile(_options: argparse.Namespace) -> int:
    from .ahead import compile_ahead

    compile_ahead(print)
    return 0


def _section_batch(options: argparse.Namespace) -> int:
    from .section.analysis.batch import run_sections

    return run_sections(options, pool=True)


if __name__ == "__main__":
    escape_control_characters()
    atexit.register(gc.freeze)  # looking for garbage at the end takes time
    sys.exit(main())
