"""Command line of the preprocessor: `python -m plymotion.preprocess body SPEC.json ...`."""

import argparse
import atexit
import gc
import sys
from collections.abc import Sequence
from pathlib import Path

from ..solver.errors import InputError, escape_control_characters
from ..solver.package.common.plain_data import shard
from ..solver.system.interrupts import INTERRUPTED, exit_code, handled_signals
from .mesh_input import scripts

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
    with handled_signals():
        return exit_code(_guarded(options))


def _guarded(options: argparse.Namespace) -> int:
    """Run a command; turn what it raises into a message and an exit code."""
    try:
        if options.command == "compile":
            from .ahead import compile_ahead

            compile_ahead(print)
            return 0
        if getattr(options, "out", None) and (
            len(options.specs) > 1 or options.specs == [Path("-")]
        ):
            print("error: --out: expected one SPEC.json; several need --out-dir", file=sys.stderr)
            return 2
        from .products import run  # here, so that --help needs no HDF5

        with scripts(refused=options.no_scripts):
            return run(options)
    except OSError as error:
        print(f"error: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        return 2
    except (InputError, ImportError) as error:
        if not type(error).__module__.startswith("plymotion."):
            raise
        print(f"error: {error}", file=sys.stderr)  # or what is missing of FEniCSx
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
    sections = "{}: stiffness, mass, recovery of stresses."
    for name, help_, description, epilog in (
        ("body", "build the modal packages of bodies", "{}: modes, inertia.", BODY_EPILOG),
        (
            "solid",
            "build the modal packages of solids that are analysed alone",
            "{}: modes, inertia.",
            BODY_EPILOG,
        ),
        ("section", "analyse cross-sections", sections, SECTION_EPILOG.format(ranks=RANKS_EPILOG)),
        (
            "section-batch",
            "analyse many cross-sections over the ranks of an MPI job",
            sections,
            SECTION_EPILOG.format(ranks=POOL_EPILOG),
        ),
        (
            "shell",
            "analyse laminated plates and shells",
            "{}: load cases and natural modes.",
            SHELL_EPILOG,
        ),
    ):
        command = commands.add_parser(
            name,
            help=help_,
            description=description.format(f"{help_[0].upper()}{help_[1:]}"),
            epilog=epilog,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            fromfile_prefix_chars=None if name in ("body", "solid") else "@",
        )
        _add_arguments(command, name)
    commands.add_parser(
        "compile",
        help="compile what DOLFINx needs, ahead of the first analysis",
        description="Compile what sections, shells and solids need, ahead of their first analysis.",
    )
    return parser


def _add_arguments(parser: argparse.ArgumentParser, name: str) -> None:
    """Arguments of a command that makes files."""
    add = parser.add_argument
    kind = name.removesuffix("-batch")
    asked = "body" if name in ("body", "solid") else kind
    writer = (
        "`plymotion check` or `solid` writes it"
        if asked == "body"
        else f"`plymotion {kind}` writes it"
    )
    text = f"specification of one {asked}, as {writer}"
    add("specs", nargs="+", type=Path, metavar="SPEC.json", help=text)
    add("--force", action="store_true", help="build all files, also those that are up to date")
    add("--no-scripts", action="store_true", help="refuse mesh scripts of the user (.geo, .py)")
    place = parser.add_mutually_exclusive_group()
    if kind == "shell":
        place.add_argument(
            "--out", type=Path, metavar="FILE", help="name of the file, for one SPEC"
        )
    text = (
        "of the packages (default: SPEC's)"
        if asked == "body"
        else "of the files (default: beside SPEC)"
    )
    place.add_argument("--out-dir", type=Path, metavar="DIR", help=f"folder {text}")
    if kind == "section":
        text = "refine until the estimated error of K, scaled by sqrt(Kii Kjj), is below A"
        add("--accuracy", type=float, metavar="A", help=text)
        add("--no-estimate", action="store_true", help="skip the error estimate (faster)")
    if kind in ("section", "shell"):
        what = "K" if kind == "section" else "energies and frequencies"
        text = f"compute {what} by a second method as well, and compare"
        add("--verify", action="store_true", help=text)
    if kind == "section":
        text = "only the k-th of N shares"
        add("--shard", type=shard, default=(1, 1), metavar="k/N", help=text)
    add("--json", action="store_true", help=f"print one line of JSON per {asked}")


if __name__ == "__main__":
    escape_control_characters()
    atexit.register(gc.freeze)  # looking for garbage at the end takes time
    sys.exit(main())
