"""Command line of the preprocessor: `python -m plymotion.preprocess body SPEC.json ...`."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

EPILOG = """\
Each SPEC.json becomes DIR/SPEC.vtkhdf, a modal package. A package whose stored
inputs (specification, preprocessor sources, format version) are the same is
left alone, so that make repeats no run that reads it.

exit code: 0 all packages are there; 2 a body could not be built (the others
were); 130 interrupted.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m plymotion.preprocess",
        description="From laminate, mesh and material to modal packages (needs FEniCSx).",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    body = commands.add_parser(
        "body",
        help="build the modal packages of bodies",
        description="Build the modal packages of bodies: sections, modes, inertia.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    body.add_argument(
        "specs",
        nargs="+",
        type=Path,
        metavar="SPEC.json",
        help="specification of one body, as `python -m plymotion.solver check` writes it",
    )
    body.add_argument(
        "--out-dir", type=Path, required=True, metavar="DIR", help="folder of the packages"
    )
    body.add_argument(
        "--force", action="store_true", help="build also what has not changed since the last time"
    )
    options = parser.parse_args(arguments)
    try:
        from .batch import build_all  # here, so that --help needs no FEniCSx

        return build_all(options.specs, options.out_dir, force=options.force)
    except OSError as error:
        print(f"error: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("interrupted: packages finished so far are kept", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
