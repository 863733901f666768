"""Identity of a file: format, version and checksum."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ...errors import PackageError
from .container import content_sha256, get_text, kind_of_file, set_text
from .disk_file import has_seal
from .remark import Remark

UNITS = "SI"
CHECKSUM = "content_sha256"


@dataclass(frozen=True)
class FileFormat:
    """One file format: its name, version, and the group of its data."""

    format: str
    version: tuple[int, int]
    group: str  # group of all data, which the checksum covers
    title: str  # attribute of the root that names the object


def write_identity(file: h5py.File, known: FileFormat, name: str) -> None:
    """Write format, version, the object's name and units as attributes of the root."""
    set_text(file, "format", known.format)
    file.attrs["format_version"] = np.array(known.version, dtype=np.int64)
    set_text(file, known.title, name)
    set_text(file, "units", UNITS)


def write_checksum(file: h5py.File, known: FileFormat) -> None:
    """Write the checksum, after all data."""
    set_text(file, "content_sha256", _checksum(file, known))


def _checksum(file: h5py.File, known: FileFormat) -> str:
    return content_sha256(file[known.group], get_text(file, known.title), get_text(file, "units"))


def write_file_checksum(file: h5py.File, known: Mapping[str, Any] | None = None) -> None:
    """Write the checksum of a whole file, after all data; `known` as in `content_sha256`."""
    set_text(file, CHECKSUM, content_sha256(file, without=CHECKSUM, known=known))


def check_file_checksum(path: Path, file: h5py.File, error: type[Exception]) -> None:
    """Compare a whole file with its checksum. Raises `error`.

    `open_file` has compared all bytes of a file with a seal, which takes a tenth of the time.
    """
    stored = get_text(file, CHECKSUM)
    if stored and has_seal(path):
        return
    actual = content_sha256(file, without=CHECKSUM)
    if actual != stored:
        found = f"{stored[:12]}..." if stored else "none"
        raise error(
            f"{path}: {CHECKSUM}: content was altered after writing, or is incomplete: "
            f"expected {actual[:12]}..., found {found}"
        )


def unit_findings(file: h5py.File) -> list[Remark]:
    """Check that the numbers of a file are in SI units."""
    units = get_text(file, "units", UNITS)
    if units == UNITS:
        return []
    return [Remark("error", "/", f"attribute units: expected {UNITS!r}, found {units!r}")]


def identity_notes(path: Path, file: h5py.File, known: FileFormat) -> list[Remark]:
    """Check that the format and version of a file are known. Raises PackageError."""
    found = get_text(file, "format")
    if found != known.format:
        what = f"{found!r}" if found else kind_of_file(file)
        raise PackageError(f"{path}: attribute format: expected {known.format!r}, this is {what}")
    major, minor = version_of(path, file, PackageError)
    if major != known.version[0]:
        age = "a newer" if major > known.version[0] else "an older"
        raise PackageError(
            f"{path}: written by {age} Plymotion: format {major}.{minor}, "
            f"this reader knows {known.version[0]}.x"
        )
    if not isinstance(file.get(known.group), h5py.Group):
        raise PackageError(f"{path}: /{known.group}: missing group")
    if minor <= known.version[1]:
        return []
    newest = ".".join(map(str, known.version))
    text = f"{path}: format {major}.{minor} is newer than {newest}: parts of it are not read"
    return [Remark("warning", "format_version", text)]


def version_of(path: Path, file: h5py.File, error: type[Exception]) -> tuple[int, int]:
    """Return major and minor version of a file's format. Raises `error` for other values."""
    try:
        major, minor = (int(v) for v in np.ravel(file.attrs["format_version"]))
    except (KeyError, ValueError, TypeError, OverflowError):
        raise error(f"{path}: attribute format_version: expected [major, minor]") from None
    return major, minor


def checksum_findings(file: h5py.File, known: FileFormat, *, whole: bool = False) -> list[Remark]:
    """Compare the content with the stored checksum.

    Without `whole`, not that of a file with a seal: `open_file` has compared all its bytes.
    """
    stored = get_text(file, "content_sha256")
    if not stored:
        return [Remark("warning", "content_sha256", "no checksum: damage cannot be detected")]
    if not whole and has_seal(Path(file.filename)):
        return []
    actual = _checksum(file, known)
    if actual == stored:
        return []
    text = f"content was altered after writing: expected {stored[:12]}..., found {actual[:12]}..."
    return [Remark("error", "content_sha256", text)]


def json_text(where: str, value: Any) -> str:
    """Return JSON text; arrays become lists. Raises PackageError for values that are not JSON."""
    try:
        return json.dumps(value, default=_plain)
    except (TypeError, ValueError) as cause:
        raise PackageError(f"{where}: {cause}") from cause


def json_table(where: str, text: str) -> dict[str, Any]:
    """Return the table of a JSON text. Raises PackageError."""
    try:
        found = json.loads(text)
    except json.JSONDecodeError as cause:
        raise PackageError(f"{where}: not JSON: {cause}") from cause
    return found if isinstance(found, dict) else {where.rsplit(" ", 1)[-1]: found}


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"cannot be written as JSON: {value!r}")


# Entries of a provenance that are shown, and their types: other programs write these files, too.
SHOWN: dict[str, tuple[type, ...]] = {
    "dofs": (int,),
    "seconds": (int, float),
    "refinements": (list,),
    "verification": (str, type(None)),
}
STEP = ("dofs", "error", "seconds")  # numbers of each of `refinements`


def check_provenance(file: Path, provenance: Mapping[str, Any]) -> None:
    """Raise PackageError if an entry that is shown is of another type."""
    for key, types in SHOWN.items():
        if key in provenance and not isinstance(provenance[key], types):
            names = " or ".join("none" if t is type(None) else t.__name__ for t in types)
            raise PackageError(
                f"{file}: provenance.{key}: expected {names}, found {provenance[key]!r:.40}"
            )
    steps = provenance.get("refinements", [])
    for row, step in enumerate(steps if len(steps) > 1 else []):  # one is not shown
        for key in STEP:
            if not isinstance(step, dict) or not isinstance(step.get(key), int | float):
                raise PackageError(
                    f"{file}: provenance.refinements[{row}].{key}: expected a number"
                )
