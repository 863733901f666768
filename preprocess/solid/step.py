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
_LIST = re.compile(rf"\(\s*(?:{_PARAMETER}\s*(?:,\s*{_PARAMETER}\s*)*)?\)")  # @: a list within
_ENTITY = re.compile(r"#(\d+)\s*=\s*(?:!?[A-Za-z]\w*\s*@|\(\s*(?:!?[A-Za-z]\w*\s*@\s*)+\)|@)\s*")
_REFERENCE = re.compile(r"#(\d+)")
BEGIN, END = "ISO-10303-21;", "END-ISO-10303-21;"


def check_step(path: Path) -> None:
    """Check that a STEP file is complete, and that its entities refer to entities of the file.

    Raises
    ------
    MeshError : no STEP file, a statement with wrong syntax, an entity that is missing or there
        twice, with its line; no unit of length.
    """
    try:
        _check(path.read_text(encoding="latin-1"))
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from None


def _check(text: str) -> None:
    if not text.lstrip().startswith(BEGIN):
        raise MeshError(f"line 1: expected {BEGIN} as the first line of a STEP file")
    text, end, _ = text.partition(END)  # a signature may follow
    if not end:
        last = text.count("\n") + 1
        raise MeshError(f"line {last}: expected {END} as its end: the file is not complete")
    known: dict[str, int] = {}
    wanted: dict[str, int] = {}
    for line, statement in _statements(text):
        short, count = statement, 1
        while count:
            short, count = _LIST.subn("@", short)
        entity = _ENTITY.fullmatch(short)
        if entity is None:
            shown = " ".join(statement.split())[:60]
            raise MeshError(f"line {line}: {shown}: expected #NUMBER = NAME(PARAMETERS);")
        if (first := known.setdefault(entity[1], line)) != line:
            raise MeshError(
                f"line {line}: #{entity[1]} is in line {first}, too; expected one of it"
            )
        for other in _REFERENCE.findall(statement, entity.end(1)):
            wanted.setdefault(other, line)
    for number, line in wanted.items():
        if number not in known:
            raise MeshError(
                f"line {line}: expected #{number} in the file, which has no such entity"
            )
    if "LENGTH_UNIT" not in text:
        raise MeshError("has no LENGTH_UNIT; expected a STEP file with its unit of length")


def _statements(text: str) -> Iterator[tuple[int, str]]:
    """Line and text of the entities, without comments, their texts as ''."""

    def blank(token: re.Match[str]) -> str:
        if token[0].startswith("'") and _SWALLOWED.search(token[0]):
            line = text.count("\n", 0, token.start()) + 1
            raise MeshError(
                f"line {line}: the text that begins here has no end; expected another '"
            )
        return ("''" if token[0].startswith("'") else " ") + "\n" * token[0].count("\n")

    line, inside = 1, False
    for statement in _TEXT.sub(blank, text).split(";"):
        start = statement.lstrip()
        name = start.partition("(")[0].rstrip()
        if name in ("DATA", "ENDSEC"):
            inside = name == "DATA"
        elif inside:
            yield line + statement[: len(statement) - len(start)].count("\n"), start
        line += statement.count("\n")
