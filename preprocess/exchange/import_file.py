"""From an import file (arm.toml) to a modal package."""

import dataclasses
import importlib
import time
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import cast, get_args

from numpy.linalg import LinAlgError
from scipy.sparse.linalg import ArpackError

from ...solver.errors import InputError, PackageError, did_you_mean, printable
from ...solver.math.disk_cache import file_sha256
from ...solver.package import ModalPackage
from ...solver.package.common.plain_data import SpecError, check_form
from ...solver.package.specification import ImportedSpecification
from .formats.modal import modal_package
from .free_body import FreeBody
from .import_table import Files, ImportFile, Reduction, Source
from .reduce import Tell, reduce_body

SOURCES = get_args(Source)
MOST_LETTERS = 100  # of a name, as in a case
OWN_KEYS = ("format", "from", "files")
# What readers and the HDF5 library raise where a file is not what it should be.
DAMAGE = (
    *(ValueError, ArithmeticError, LookupError, MemoryError),
    *(RuntimeError, AttributeError, TypeError),
)


def read_table(file: Path) -> ImportFile:
    """The table of an import file, with its form checked. Raises InputError."""
    try:
        table = tomllib.loads(file.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputError(f"{file}: no such file; expected an import file (TOML)") from error
    except (ValueError, RecursionError) as error:  # the syntax, a number of thousands of digits
        raise InputError(f"{file}: {error}") from error
    return checked(table, str(file))


def checked(content: Mapping[str, object], where: str) -> ImportFile:
    """Return the table of an import file with the default of `reference`, that of a case.

    Raises
    ------
    InputError : a key that is unknown or missing, or a value of another type.
    """
    reference = content.get("reference", {"kind": "clamped"})
    if isinstance(reference, dict) and reference.get("kind") == "clamped":
        reference = {"at": "root", **reference}
    try:
        table = check_form({**content, "reference": reference}, ImportFile)
    except SpecError as error:
        raise InputError(f"{where}: {error}") from error
    names = [("body", table["body"]), *(("interfaces", name) for name in table["interfaces"])]
    for key, name in names:
        if not 0 < len(name) <= MOST_LETTERS or printable(name) != name:
            raise InputError(
                f"{where}: {key}: the name {printable(name[:40])!r}: expected 1 to {MOST_LETTERS} "
                "letters without control characters"
            )
    return table


def imported(
    table: ImportFile,
    folder: Path,
    where: str,
    source: "str | None" = None,
    tell: Tell = lambda _: None,
) -> ModalPackage:
    """Modal package of the body that an import file describes.

    Parameters
    ----------
    table : content of the file, see `read_table`
    folder : where its paths start
    where : name of the file, for messages
    source : instead of the key `from`

    Raises
    ------
    InputError : a file is missing or wrong, or the matrices are not those of a free body.
    """
    kind = str(source or table.get("from", ""))
    if kind not in SOURCES:
        hint = did_you_mean(kind, SOURCES)
        raise InputError(
            f"{where}: from = {kind!r}: expected one of {', '.join(SOURCES)}, here or by --from"
            f"{hint}"
        )
    files = Files(table["files"], folder, where)
    tell(f"reading {kind}")
    code, _, modes = kind.partition("-")
    reader = importlib.import_module(f"{__package__}.formats.{code}")
    try:
        body = reader.read_modes(files) if modes else reader.read(files)
    except (InputError, PackageError):
        raise
    except DAMAGE as error:
        what = " ".join(str(error).split())[:200] or type(error).__name__
        raise InputError(
            f"{where}: {files.latest()}: damaged, or not as {kind} writes it ({what})"
        ) from error
    reduction = cast(Reduction, {k: v for k, v in table.items() if k not in OWN_KEYS})
    try:
        if isinstance(body, FreeBody):
            return reduce_body(body, reduction, tell)
        return modal_package(body, reduction, files)
    except (ArpackError, LinAlgError, ArithmeticError, MemoryError) as error:
        what = " ".join(str(error).split())[:200] or type(error).__name__
        raise InputError(
            f"{where}: no modes of these matrices are found ({what}); expected the stiffness "
            "and mass of a body, all entries correct"
        ) from error


def _unchanged(folder: Path, digests: dict[str, str]) -> None:
    for name, digest in digests.items():
        path = folder / name
        if not path.is_file() or file_sha256(path) != digest:
            raise InputError(f"{path}: changed since `plymotion check`; check the case again")


def build_imported(content: Mapping[str, object]) -> ModalPackage:
    """Read and reduce the matrices that a specification names.

    Raises SpecError: a wrong key or file, or matrices that are not those of a free body.
    """
    spec = check_form(content, ImportedSpecification)
    file = Path(spec["file"])
    start = time.perf_counter()
    try:
        _unchanged(file.parent, spec["sha256"])
        package = imported(checked(spec["table"], str(file)), file.parent, str(file))
        _unchanged(file.parent, spec["sha256"])  # nor while it was read
    except InputError as error:
        raise SpecError(str(error)) from error
    seconds = time.perf_counter() - start
    provenance = {
        **package.provenance,
        "command": "python -m plymotion.preprocess body",
        "inputs_sha256": spec.get("inputs_sha256"),
        "spec": content,
        "dofs": {"body": 3 * package.provenance["nodes_of_source"]},
        "seconds": {"modes": seconds},
    }
    return dataclasses.replace(package, body=spec["body"], provenance=provenance)
