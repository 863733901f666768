"""Command line: `python -m plymotion.preprocess.exchange import | export`; light environment."""

import argparse
import importlib
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from ...solver.errors import InputError, PackageError, escape_control_characters
from ...solver.system.interrupts import INTERRUPTED


def main(arguments: "Sequence[str] | None" = None) -> int:
    """Run one command; returns the exit code: 0 done, 2 wrong input, 130 interrupted."""
    options = _parser().parse_args(arguments)
    try:
        return int(options.run(options))
    except (InputError, PackageError) as error:
        for line in str(error).splitlines():
            print(f"error: {line}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"error: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("interrupted: nothing written", file=sys.stderr)
        return INTERRUPTED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m plymotion.preprocess.exchange")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    into = commands.add_parser("import", help="modal package of a body of another code")
    into.add_argument("file", type=Path)
    into.add_argument("--from", dest="source")
    into.add_argument("--out", "-o", type=Path, required=True)
    into.add_argument("--quiet", action="store_true")
    into.set_defaults(run=_import)
    away = commands.add_parser("export", help="modal package in the format of another code")
    away.add_argument("package", type=Path)
    away.add_argument("--to", dest="target", required=True)
    away.add_argument("--out", "-o", type=Path)
    away.set_defaults(run=_export)
    return parser


def _import(options: argparse.Namespace) -> int:
    from ...solver.package.common.files import refuse_foreign
    from ...solver.package.validation import write_valid
    from .import_file import imported, read_table

    table = read_table(options.file)
    refuse_foreign(options.out)  # before the work
    start = time.perf_counter()

    def tell(step: str) -> None:
        if not options.quiet:
            print(f"[{time.perf_counter() - start:6.1f} s] {step}", file=sys.stderr, flush=True)

    where, folder = str(options.file), options.file.parent
    package = imported(table, folder, where, options.source, tell)
    for warning in package.provenance["warnings"]:
        print(f"warning [{warning['code']}] {warning['message']}", file=sys.stderr)
    write_valid(options.out, package, where)
    hertz = package.frequencies / 6.283185307179586
    span = f", {hertz[0]:.6g} to {hertz[-1]:.6g} Hz" if len(hertz) else ""
    print(f"{options.out}: {package.body}, {package.n_mode} modes{span}")
    return 0


def _export(options: argparse.Namespace) -> int:
    from ...solver.package import read_package

    try:
        writer = importlib.import_module(f"{__package__}.formats.{options.target}")
        write, suffix = writer.write, writer.SUFFIX
    except (ModuleNotFoundError, AttributeError) as error:
        raise InputError(f"export --to {options.target}: no format that is written") from error
    package = read_package(options.package)
    stem = options.package.stem.replace("-", "_")
    default = options.package.with_name(f"{stem}_{options.target}{suffix}")
    out = options.out or default
    if out.resolve() == options.package.resolve():
        raise InputError(f"{out}: expected another name than that of the package")
    out.parent.mkdir(parents=True, exist_ok=True)
    print(f"{out}: {write(package, out, options.package)}")
    return 0


if __name__ == "__main__":
    escape_control_characters()
    sys.exit(main())
