"""Modal packages of bodies made by a batch."""

import argparse
import math
import time
from pathlib import Path
from typing import Any

from ..solver.package.body.schema import ModalPackage
from ..solver.package.fingerprint import fingerprint, has_fingerprint
from ..solver.package.validation import write_valid
from .batch import build_all
from .reporting import build_from_stdin, reporter


def build_bodies(options: argparse.Namespace) -> int:
    """Build the requested packages; returns the exit code."""
    out_dir: Path | None = options.out_dir
    if out_dir is not None:
        out_dir.mkdir(parents=True, exist_ok=True)

    def target_of(spec: Path) -> Path:
        return (out_dir or spec.parent) / f"{spec.stem}.vtkhdf"

    with reporter(options.json, first=True) as (report, _):
        how: dict[str, Any] = {"force": options.force, "report": report}
        if options.specs == [Path("-")]:
            return build_from_stdin(BodyPackages(), target_of, **how)
        return build_all(BodyPackages(), options.specs, target_of, **how)


class BodyPackages:
    """Makes the modal package of one body from its specification."""

    def unchanged(self, target: Path, spec: dict[str, Any]) -> bool:
        """True if the target is a valid package made from the same inputs."""
        return has_fingerprint(target, fingerprint(spec))

    def make(self, spec: dict[str, Any], target: Path) -> tuple[str, list[dict[str, str]]]:
        """Build and write the package."""
        start = time.perf_counter()
        package = _built(spec)
        write_valid(target, package, f"body {package.body}", own=True)  # also a damaged one
        text = _summary(package, time.perf_counter() - start)
        return text, package.provenance["warnings"]


def _built(spec: dict[str, Any]) -> ModalPackage:
    """Build a body. FEniCSx is loaded only if it is needed."""
    if isinstance(spec, dict) and spec.get("kind") == "imported":
        from .exchange.import_file import build_imported

        return build_imported(spec)
    from .body import build_body

    return build_body(spec)


def _summary(package: ModalPackage, total: float) -> str:
    seconds, dofs = package.provenance["seconds"], package.provenance["dofs"]
    hertz = package.frequencies / (2.0 * math.pi)
    span = f", {hertz[0]:.4g} to {hertz[-1]:.4g} Hz" if len(hertz) else ""
    first = next(iter(seconds))  # "section" of a beam, "shell"
    return (
        f"{first} {seconds[first]:.2f} s, modes {seconds['modes']:.2f} s, "
        f"{dofs.get('section', dofs['body'])} dofs ({total:.2f} s in all; {package.n_mode} "
        f"modes{span})"
    )
