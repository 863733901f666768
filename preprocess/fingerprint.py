"""Content hash of all inputs of a modal package.

A package is rebuilt only if this hash differs from the stored one. The hash includes
the specification of the body, the sources of the preprocessor, the mesh scripts, and the
format version.
"""

import functools
from pathlib import Path
from typing import Any

from ..solver.package.body.schema import FORMAT_VERSION
from ..solver.package.common.file_digests import files_sha256
from ..solver.package.common.plain_data import inputs_sha256

# These keys do not affect the body: a new integrator setting
# # in the case file must not rebuild its packages.
NOT_INPUTS = ("inputs_sha256", "case")


def fingerprint(spec: dict[str, Any]) -> str:
    """SHA-256 of a body specification, the sources and the format version.

    The version of DOLFINx is not included: all versions give the same numbers (to 1e-9,
    tested).
    """
    inputs = {key: value for key, value in spec.items() if key not in NOT_INPUTS}
    return inputs_sha256([inputs, list(FORMAT_VERSION), _sources_sha256()])


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
    return files_sha256(files)
