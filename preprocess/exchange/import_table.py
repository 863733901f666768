"""Import files (arm.toml): their form, also in Python, and the files that they name."""

import re
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal, NotRequired, TypedDict

from ... import __version__
from ...solver.errors import InputError, nearest
from ...solver.math.disk_cache import file_sha256
from ...solver.package.specification import Attachment, LinkKind, ReferenceTable

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254, "ft": 0.3048}
MASSES = {
    "kg": 1.0,
    "g": 1e-3,
    "t": 1e3,
    "lb": 0.45359237,
    "slug": 14.59390293720636,
    "slinch": 175.12683524647636,  # lbf s2/in
}
TIMES = {"s": 1.0, "ms": 1e-3}


class UnitsTable(TypedDict):
    """`units` of an import file; force and stress follow, e.g. N and MPa from mm, t, s."""

    length: Literal["m", "cm", "mm", "in", "ft"]
    mass: Literal["kg", "g", "t", "lb", "slug", "slinch"]
    time: Literal["s", "ms"]


SI: UnitsTable = {"length": "m", "mass": "kg", "time": "s"}


def sizes(units: UnitsTable) -> tuple[float, float, float]:
    """Size of the units of length, mass and time [m, kg, s]."""
    return LENGTHS[units["length"]], MASSES[units["mass"]], TIMES[units["time"]]


Source = Literal[
    "matrices", "calculix", "calculix-modes", "nastran", "med", "uff", "ansys", "ansys-modes"
]


class InterfaceTable(TypedDict):
    """`[interfaces.NAME]`: nodes of one of `set`, `nodes`, `box`, and how they carry the joint."""

    link: LinkKind
    set: NotRequired[str]
    nodes: NotRequired[list[int]]
    box: NotRequired[list[list[float]]]
    weights: NotRequired[Literal["equal", "area"]]
    position: NotRequired[list[float]]
    rotation_deg: NotRequired[list[float]]


class Vibrations(TypedDict):
    """The lowest vibration modes."""

    kind: Literal["lowest"]
    count: int


class Reduction(TypedDict):
    """What becomes of the matrices: the part of an import file that is not about files."""

    body: str
    reference: ReferenceTable
    modes: list[Vibrations | Attachment]
    interfaces: dict[str, InterfaceTable]
    units: UnitsTable
    total_mass: NotRequired[float]
    damping_ratio: NotRequired[float]


_From = TypedDict("_From", {"from": NotRequired[Source]})  # a word of Python


class ImportFile(Reduction, _From):
    """The whole file."""

    format: Literal[1]
    files: dict[str, object]


def damping_ratio(table: Reduction, where: str) -> float:
    """Return the key of this name, 0 without it. Raises InputError for an impossible ratio."""
    ratio = float(table.get("damping_ratio", 0.0))
    if not 0.0 <= ratio < 1.0:
        expected = "expected a fraction of critical, from 0 to below 1"
        raise InputError(f"{where}: damping_ratio = {ratio:g}: {expected}")
    return ratio


def provenance(
    table: Reduction, notes: dict[str, object], nodes: int, form: str
) -> dict[str, object]:
    """Where a package comes from.

    Parameters
    ----------
    table : content of the import file
    notes : facts about the source: files, hashes
    nodes : number of nodes that the source had
    form : what the inertia follows from, such as "masses of the nodes"
    """
    return {
        "plymotion": __version__,
        "command": "plymotion import",
        "import": dict(table),
        "source": notes,
        "nodes_of_source": nodes,
        "inertia": form,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }


class Files:
    """The table `files` of an import file; paths are relative to its folder."""

    def __init__(self, table: Mapping[str, object], folder: Path, where: str) -> None:
        self.table, self.folder, self.where = table, folder, where
        self._hashes: dict[str, str] = {}

    def only(self, required: tuple[str, ...], optional: tuple[str, ...] = ()) -> None:
        """Raise InputError for an unknown or a missing key."""
        known = (*required, *optional)
        for key in self.table:
            if key not in known:
                raise InputError(f"{self.where}: files.{key}: unknown key{nearest(key, known)}")
        for key in required:
            if key not in self.table:
                raise InputError(
                    f"{self.where}: files.{key}: missing; expected a path; all keys: "
                    f"{', '.join(known)}"
                )

    def path(self, key: str) -> Path:
        """Path of a file that exists. Raises InputError otherwise."""
        name = self.table[key]
        if not isinstance(name, str):
            raise InputError(f"{self.where}: files.{key} = {name!r}: expected a path")
        path = self.folder / name
        if not path.is_file():
            raise InputError(f"{self.where}: files.{key} = {name!r}: no such file: {path}")
        if key not in self._hashes:
            self._hashes[key] = file_sha256(path)
        return path

    def beside_deck(self, key: str, suffix: str) -> None:
        """Unless the file `key` is named, it is that beside `deck` with this suffix."""
        if key not in self:
            name = str(Path(str(self.table["deck"])).with_suffix(suffix))
            self.table = {**self.table, key: name}

    def latest(self) -> str:
        """Key and name of the file that was asked for last, for messages."""
        key = next(reversed(self._hashes), "")
        return f"files.{key} = {self.table[key]!r}" if key else "files"

    def __contains__(self, key: str) -> bool:
        return key in self.table

    def notes(self) -> dict[str, object]:
        """Names and hashes of the files that were read, for the provenance."""
        names = {key: str(self.table[key]) for key in self._hashes}
        return {"files": names, "sha256": self._hashes}


EXPONENT = re.compile(r"(?<=[0-9.])([+-]\d+)$")


def fortran_number(text: str) -> float:
    """A number as Fortran writes it, with D or nothing for E: 1.5D-3, 1.5-103.

    Raises ValueError for other text.
    """
    word = text.upper().replace("D", "E")
    return float(word if "E" in word else EXPONENT.sub(r"E\1", word))


def text_lines(path: Path) -> list[str]:
    """Lines of a text file; bytes outside ASCII come from comments only."""
    return path.read_text(encoding="utf-8-sig", errors="replace").splitlines()
