"""Provenance of a modal package, for its reader and for the next build."""

import json
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime

from .. import __version__
from . import fenicsx

LONGEST = 40_000  # characters of a specification in a package; an attribute has at most 60 000


def body_provenance(
    spec: Mapping[str, object],
    dofs: dict[str, int],
    seconds: dict[str, float],
    warnings: Sequence[dict[str, str]],
) -> dict[str, object]:
    """Provenance of the package of a beam or a shell.

    Parameters
    ----------
    spec : specification of the body; a long one (many nodes or stations) is not repeated, it is
        in the file from which the package was built
    dofs, seconds : unknowns and time of each part of the work
    warnings : {"code", "message"} of each
    """
    return {
        "plymotion": __version__,
        "versions": fenicsx.versions(),
        "command": "python -m plymotion.preprocess body",
        "inputs_sha256": spec.get("inputs_sha256"),
        "case": spec.get("case"),
        "spec": spec if len(json.dumps(spec)) <= LONGEST else None,
        "ranks": 1,
        "dofs": dofs,
        "seconds": seconds,
        "warnings": list(warnings),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
