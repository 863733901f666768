"""Whether a package, section or shell file was made from the inputs that it would be made from now.

A file keeps the hash of its specification, as it was read, of the sources of the preprocessor and
of the format. The preprocessor writes it; both halves compare it before they build anything.
"""

import json
from pathlib import Path
from typing import Any

from ..errors import PackageError
from ..math.disk_cache import sources_sha256
from .common.container import get_text, open_file
from .common.disk_file import has_right_seal
from .common.plain_data import inputs_sha256
from .specification import FORMAT_VERSION

# These keys do not affect the body: a new integrator setting
# in the case file must not rebuild its packages.
NOT_INPUTS = ("inputs_sha256", "case")
SOURCES = ("preprocess", "meshes", "solver/package", "solver/math")


def fingerprint(spec: dict[str, Any]) -> str:
    """SHA-256 of a body specification, the sources and the format version.

    The version of DOLFINx is not included: all versions give the same numbers (to 1e-9,
    tested).
    """
    inputs = {key: value for key, value in spec.items() if key not in NOT_INPUTS}
    return inputs_sha256([inputs, list(FORMAT_VERSION), sources_sha256(*SOURCES)])


def has_fingerprint(file: Path, expected: str) -> bool:
    """Tell whether a file has this fingerprint, and all bytes as they were written."""
    try:
        with open_file(file, PackageError) as content:
            found = json.loads(get_text(content, "provenance", "{}")).get("fingerprint")
    except (PackageError, ValueError, AttributeError):
        return False
    return bool(found == expected) and has_right_seal(file)
