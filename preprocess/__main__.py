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

EPILOG = """\
Writes SPEC.vtkhdf for each SPEC.json. A file whose stored inputs (specification,
options, preprocessor sources, format version) are unchanged is not written again,
so make does not repeat runs that read it. @LIST reads arguments from the lines of
the file LIST. SPEC `-` alone reads names from standard input and processes each
one immediately.
{ranks}
exit code: 0 all files are up to date; 2 a file could not be made (the others were
made); 130 interrupted.
"""
RANKS = """
`mpirun -n N python -m plymotion.preprocess {name} ...` analyses one {name} after
the other with all ranks, each with its own cells; rank 0 writes and prints.
"""
COMMANDS = {
    "body": "build the modal packages of bodies: modes, inertia",
    "solid": "build the modal packages of solids that are analysed alone",
    "section": "analyse cross-sections: stiffness, mass, recovery of stresses",
    "shell": "analyse laminated plates and shells: load cases and natural modes",
}
WITH_RANKS = ("section", "shell", "solid")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code."""
    options = _parser().parse_args(arguments)
    with handled_signals():
        return exit_code(_guarded(options))


def _guarded(options: argparse.Namespace) -> int:
    """Run a command; turn what it raises into a message and an exit code."""
    try:
        if options.command == "compile":
            from .precompile import compile_ahead

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
    for name, text in COMMANDS.items():
        command = commands.add_parser(
            name,
            help=text,
            description=f"{text[0].upper()}{text[1:]}.",
            epilog=EPILOG.format(ranks=RANKS.format(name=name) if name in WITH_RANKS else ""),
            formatter_class=argparse.RawDescriptionHelpFormatter,
            fromfile_prefix_chars="@",
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
    of, writer = "body" if name == "solid" else name, "check" if name == "body" else name
    text = f"specification of one {of}, as `plymotion {writer}` writes it"
    add("specs", nargs="+", type=Path, metavar="SPEC.json", help=text)
    add("--force", action="store_true", help="build all files, also those that are up to date")
    add("--no-scripts", action="store_true", help="refuse mesh scripts of the user (.geo, .py)")
    place = parser.add_mutually_exclusive_group()
    if name == "shell":
        text = "name of the file, for one SPEC"
        place.add_argument("--out", type=Path, metavar="FILE", help=text)
    text = "folder of the files (default: beside SPEC)"
    place.add_argument("--out-dir", type=Path, metavar="DIR", help=text)
    if name == "section":
        text = "refine until the estimated error of K, scaled by sqrt(Kii Kjj), is below A"
        add("--accuracy", type=float, metavar="A", help=text)
        add("--no-estimate", action="store_true", help="skip the error estimate (faster)")
        text = "only the k-th of N shares"
        add("--shard", type=shard, default=(1, 1), metavar="k/N", help=text)
    if name == "body":
        text = "write SPEC.packed, without HDF5, for another process of the same version"
        add("--packed", action="store_true", help=text)
    if name in ("section", "shell"):
        text = "compute K, or energies and frequencies, by a second method as well, and compare"
        add("--verify", action="store_true", help=text)
    add("--json", action="store_true", help=f"print one line of JSON per {of}")


if __name__ == "__main__":
    escape_control_characters()
    atexit.register(gc.freeze)  # looking for garbage at the end takes time
    sys.exit(main())
