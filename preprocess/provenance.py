"""Provenance of a modal package, for its reader and for the next build."""

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from .. import __version__
from . import fenicsx
from .fingerprint import fingerprint


def body_provenance(
    spec: dict[str, Any],
    dofs: dict[str, int],
    seconds: dict[str, float],
    warnings: Sequence[dict[str, str]],
) -> dict[str, Any]:
    """Provenance of the package of a beam or a shell.

    Parameters
    ----------
    spec : specification of the body
    dofs, seconds : unknowns and time of each part of the work
    warnings : {"code", "message"} of each
    """
    return {
        "plymotion": __version__,
        "versions": fenicsx.versions(),
        "command": "python -m plymotion.preprocess body",
        "fingerprint": fingerprint(spec),
        "inputs_sha256": spec.get("inputs_sha256"),
        "case": spec.get("case"),
        "spec": spec,
        "ranks": 1,
        "dofs": dofs,
        "seconds": seconds,
        "warnings": list(warnings),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
