"""Modal package of a body with kind = "imported" of a case."""

import dataclasses
import time
from pathlib import Path
from typing import Any, cast

from ...solver.errors import InputError
from ...solver.math.digests import file_sha256
from ...solver.package import ModalPackage
from ...solver.package.body.specification import ImportedSpecification
from ...solver.package.common.table_form import SpecError, check_form
from ...solver.package.fingerprint import fingerprint
from .import_file import check_table, package_of


def build_imported(content: dict[str, Any]) -> ModalPackage:
    """Read and reduce the matrices that a specification names.

    Raises SpecError: a wrong key or file, or matrices that are not those of a free body.
    """
    check_form(content, ImportedSpecification)
    spec = cast(ImportedSpecification, content)
    file = Path(spec["file"])
    start = time.perf_counter()
    try:
        for name, digest in spec["sha256"].items():
            path = file.parent / name
            if not path.is_file() or file_sha256(path) != digest:
                raise InputError(f"{path}: changed since `plymotion check`; check the case again")
        check_table(spec["table"], str(file))
        package = package_of(spec["table"], file.parent, str(file))
    except InputError as error:
        raise SpecError(str(error)) from error
    seconds = time.perf_counter() - start
    provenance = {
        **package.provenance,
        "command": "python -m plymotion.preprocess body",
        "fingerprint": fingerprint(content),
        "inputs_sha256": spec.get("inputs_sha256"),
        "spec": content,
        "dofs": {"body": 3 * package.provenance["nodes_of_source"]},
        "seconds": {"modes": seconds},
    }
    return dataclasses.replace(package, body=spec["body"], provenance=provenance)
