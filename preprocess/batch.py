"""Many bodies in one process: imports, compiled forms and equal sections are shared."""

import json
import math
import sys
import time
import traceback
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..solver.package.io import read_package, write_package
from ..solver.package.schema import ModalPackage, PackageError
from .fingerprint import fingerprint

USER_ERROR = 2


def build_all(specs: Sequence[Path], out_dir: Path, *, force: bool = False) -> int:
    """Build the package of every specification file; returns the exit code.

    One line of progress for every body on stdout, one line for every error on
    stderr. A body that fails does not stop the others.

    Parameters
    ----------
    specs : JSON files, one body each
    out_dir : the packages become out_dir/<stem>.vtkhdf
    force : build also what has not changed
    """
    out_dir.mkdir(parents=True, exist_ok=True)
    code = 0
    for count, path in enumerate(specs, start=1):
        label = f"[{count}/{len(specs)}] {path.stem}"
        try:
            spec = _read(path)
            target = out_dir / f"{path.stem}.vtkhdf"
            if not force and _unchanged(target, spec):
                print(f"{label}: unchanged", flush=True)
                continue
            print(f"{label}: {_build(spec, target)}", flush=True)
        except Exception as error:
            code = USER_ERROR
            if not _is_user_error(error):
                traceback.print_exc()
                print("this is a defect of the preprocessor, not of the input:", file=sys.stderr)
            text = " ".join(str(error).split()) or type(error).__name__
            print(f"error: {path}: {text}", file=sys.stderr, flush=True)
    return code


def _is_user_error(error: Exception) -> bool:
    """Tell errors with a message for the user from defects.

    The errors that Plymotion raises itself carry such a message; so do those
    of the operating system (a folder that cannot be written).
    """
    return type(error).__module__.startswith("plymotion.") or isinstance(error, OSError)


def _read(path: Path) -> dict[str, Any]:
    from .beam.spec import SpecError

    try:
        spec = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise SpecError("no such file") from error
    except (json.JSONDecodeError, UnicodeDecodeError) as error:
        raise SpecError(f"not JSON: {error}") from error
    if not isinstance(spec, dict):
        raise SpecError(f"expected a JSON object, found {type(spec).__name__}")
    return spec


def _unchanged(target: Path, spec: dict[str, Any]) -> bool:
    """True if the target is a sound package made from these very inputs."""
    if not target.exists():
        return False
    try:
        stored = read_package(target).provenance.get("fingerprint")
    except PackageError:
        return False  # damaged or older: made anew
    return stored == fingerprint(spec)


def _build(spec: dict[str, Any], target: Path) -> str:
    from .body import build_body

    start = time.perf_counter()
    package = build_body(spec)
    write_package(target, package)
    for warning in package.provenance["warnings"]:
        text = f"warning: {target.stem}: {warning['code']}: {warning['message']}"
        print(text, file=sys.stderr, flush=True)
    return _summary(package, time.perf_counter() - start)


def _summary(package: ModalPackage, total: float) -> str:
    seconds, dofs = package.provenance["seconds"], package.provenance["dofs"]
    hertz = package.frequencies / (2.0 * math.pi)
    span = f", {hertz[0]:.4g} to {hertz[-1]:.4g} Hz" if len(hertz) else ""
    return (
        f"section {seconds['section']:.2f} s, modes {seconds['modes']:.2f} s, "
        f"{dofs['section']} dofs ({total:.2f} s in all; {package.n_mode} modes{span})"
    )
