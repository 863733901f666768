"""Content hash of all inputs of a modal package.

A package is rebuilt only if this hash differs from the stored one. The hash includes
the specification of the body, the sources of the preprocessor, the mesh scripts, and the
format version.
"""

import functools
import hashlib
import json
from pathlib import Path
from typing import Any

from ..solver.package.body.schema import FORMAT_VERSION

# These keys do not affect the body: a new integrator setting
# # in the case file must not rebuild its packages.
NOT_INPUTS = ("inputs_sha256", "case")
PLACES = ("file", "arrays")


def canonical(table: Any) -> str:
    """JSON text that is the same for the same content."""
    return json.dumps(table, sort_keys=True, separators=(",", ":"))


def fingerprint(spec: dict[str, Any]) -> str:
    """SHA-256 of a body specification, the sources and the format version.

    The version of DOLFINx is not included: all versions give the same numbers (to 1e-9,
    tested).
    """
    text = canonical([_inputs(spec), list(FORMAT_VERSION), _sources_sha256()])
    return hashlib.sha256(text.encode()).hexdigest()


def _inputs(table: Any) -> Any:
    """The inputs in a specification. A mesh is identified by its content, not by its path."""
    if isinstance(table, list):
        return [_inputs(value) for value in table]
    if not isinstance(table, dict):
        return table
    left_out = (*NOT_INPUTS, *(PLACES if "sha256" in table else ()))
    return {key: _inputs(value) for key, value in table.items() if key not in left_out}


@functools.cache
def _sources_sha256() -> str:
    here = Path(__file__).resolve().parent
    files = {f"preprocess/{p.relative_to(here).as_posix()}": p for p in here.rglob("*.py")}
    for folder in (here.parent / "meshes", here.parent.parent / "meshes"):
        scripts = [p for p in folder.rglob("*.*") if p.suffix in (".geo", ".py")]
        files |= {f"meshes/{p.relative_to(folder).as_posix()}": p for p in scripts}
    solver = here.parent / "solver"
    for folder in (solver / "package", solver / "math"):  # all that the preprocessor may import
        files |= {p.relative_to(solver).as_posix(): p for p in folder.rglob("*.py")}
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(f"{name}\0".encode() + files[name].read_bytes() + b"\0")
    return digest.hexdigest()
