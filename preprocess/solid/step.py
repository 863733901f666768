"""Structure of STEP files (ISO 10303-21), which OpenCASCADE reads without checks of its own.

It ends by a signal where an entity is missing, and takes entities with faulty parameters as empty.
"""

import re
from collections.abc import Iterator
from pathlib import Path

from ..fenicsx import MeshError

_TEXT = re.compile(r"'(?:[^']|'')*'?|/\*.*?\*/", re.DOTALL)
_SWALLOWED = re.compile(r";\s*(?:#\d+\s*=|ENDSEC)")  # of the statements behind a text
_PARAMETER = (
    r"(?:#\d+|[$*]|''|\"[0-9A-Fa-f]*\"|\.\w+\.|[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
    r"|(?:!?[A-Za-z]\w*\s*)?@)"
)
_LIST = re.compile(rf"\(\s*(?:{_PARAMETER}\s*(?:,\s*{_PARAMETER}\s*)*)?\)")
_ENTITY = re.compile(r"#(\d+)\s*=\s*(?:!?[A-Za-z]\w*\s*@|\(\s*(?:!?[A-Za-z]\w*\s*@\s*)+\)|@)\s*")
_REFERENCE = re.compile(r"#(\d+)")
SHOWN = 60  # characters of a statement in a message


def check_step(path: Path) -> None:
    """Check that a STEP file is complete, and that its entities refer to entities of the file.

    Raises
    ------
    MeshError : no STEP file, a statement with wrong syntax, an entity that is missing or there
        twice, with its line; no unit of length.
    """
    text = path.read_text(encoding="latin-1")
    if not text.lstrip().startswith("ISO-10303-21;"):
        raise MeshError(f"{path}: line 1: expected ISO-10303-21; as the first line of a STEP file")
    if not text.rstrip().endswith("END-ISO-10303-21;"):
        raise MeshError(
            f"{path}: line {text.count(chr(10)) + 1}: expected END-ISO-10303-21; as the last line: "
            "the file is not complete"
        )
    known: dict[str, int] = {}
    wanted: dict[str, int] = {}
    inside = False
    for line, statement in _statements(path, text):
        name = statement.partition("(")[0].strip()
        if name in ("DATA", "ENDSEC"):
            inside = name == "DATA"
        elif inside:
            short, count = statement, 1
            while count:
                short, count = _LIST.subn("@", short)
            entity = _ENTITY.fullmatch(short)
            if entity is None:
                shown = " ".join(statement.split())[:SHOWN]
                raise MeshError(
                    f"{path}: line {line}: {shown}: expected #NUMBER = NAME(PARAMETERS); of "
                    "ISO 10303-21"
                )
            number = entity[1]
            if number in known:
                raise MeshError(
                    f"{path}: line {line}: #{number} is in line {known[number]}, too; expected one "
                    "entity of each number"
                )
            known[number] = line
            for other in _REFERENCE.findall(statement, entity.end(1)):
                wanted.setdefault(other, line)
    for number, line in wanted.items():
        if number not in known:
            raise MeshError(
                f"{path}: line {line}: refers to #{number}, which the file does not have; expected "
                "a complete file"
            )
    if "LENGTH_UNIT" not in text:
        raise MeshError(f"{path}: has no LENGTH_UNIT; expected a STEP file with its unit of length")


def _statements(path: Path, text: str) -> Iterator[tuple[int, str]]:
    """Line and text of what stands before each semicolon, strings as '', without comments."""

    def blank(found: re.Match[str]) -> str:
        if found[0].startswith("'") and _SWALLOWED.search(found[0]):
            line = text.count("\n", 0, found.start()) + 1
            raise MeshError(f"{path}: line {line}: the text that begins here has no closing '")
        return ("''" if found[0].startswith("'") else " ") + "\n" * found[0].count("\n")

    line = 1
    for statement in _TEXT.sub(blank, text).split(";"):
        start = statement.lstrip()
        yield line + statement[: len(statement) - len(start)].count("\n"), start
        line += statement.count("\n")
