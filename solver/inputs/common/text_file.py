"""Files of a user as plain tables and texts: TOML, YAML, numbers in lines."""

import contextlib
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, TextIO

from ...errors import InputError, printable

# TOML files as plain tables.

Tables = dict[str, Any]  # as they are read, not checked yet
LEVELS = 100  # of tables and lists in each other
# A key of so many parts; the time of tomllib grows with the square of their number.
DOTTED = re.compile(rf"(?<![^\s.\[])(?:[^\s.,=\[\]]++\s*+\.\s*+){{{LEVELS}}}")
CASE = "case file"
# Keys that only one kind of file has: one message about them says more than one about each key.
DESCRIPTION = "description for `plymotion section` or `plymotion shell`"
KEYS = {"runs": CASE, "joints": CASE, "regions": DESCRIPTION}


def read_toml(file: Path, what: str) -> dict[str, object]:
    """Read a TOML file; `what` it is meant to be ("case file") goes into the message.

    Raises
    ------
    InputError
        No such file; not TOML; a file of another kind.
    """
    if file.exists() and not file.is_file():  # a folder, or a device that never ends
        raise InputError(f"{file}: no such {what}")
    too_deep = f"{file}: not valid TOML: nested too deep; expected {LEVELS} levels"
    text = ""
    try:
        text = file.read_text(encoding="utf-8-sig")
        if DOTTED.search(text):
            raise InputError(too_deep)
        table = tomllib.loads(text)
    except (FileNotFoundError, IsADirectoryError) as error:
        raise InputError(f"{file}: no such {what}") from error
    except RecursionError:
        raise InputError(too_deep) from None
    except ValueError as error:  # of the syntax, of UTF-8, or a number of thousands of digits
        raise InputError(f"{file}: not valid TOML: {_explained(error, text)}") from error
    if not _flat_enough(table):  # as a key of many dots
        raise InputError(too_deep)
    kind = next((kind for key, kind in KEYS.items() if key in table), None)
    if kind is not None and (kind == CASE) != (what == CASE):
        raise InputError(f"{file}: expected a {what}, found a {kind}")
    return table


def _explained(error: ValueError, text: str) -> str:
    """Return a message of the reader with the line that it is about, and what is often wrong."""
    if isinstance(error, UnicodeDecodeError):
        return f"byte {error.start} is not UTF-8: save the file in this encoding"
    number = re.search(r"at line (\d+)", str(error))
    if number is None:
        return str(error)
    line = text.split("\n")[int(number[1]) - 1].strip()
    advice = "" if line.isascii() else "; expected letters A to Z in names"
    if "Invalid value" in str(error) or "after a statement" in str(error):
        advice = "; expected numbers such as 0.5 or 1e9, true or false, or texts in quotes"
    return f"{error}: {printable(line[:60])}{advice}"


def _flat_enough(table: Mapping[str, Any]) -> bool:
    level: list[Any] = [table]
    for _ in range(LEVELS):
        within = [item.values() if isinstance(item, dict) else item for item in level]
        level = [item for items in within for item in items if isinstance(item, dict | list)]
        if not level:
            return True
    return False


# YAML files as plain tables.
#
# Sizes are bounded while the file is read: a few bytes of YAML can mean any number of levels, or,
# by aliases of aliases, of values. Reused anchors mean the last one, as in windIO's reader; a key
# that a table has twice is an error.

BYTES = 64 * 2**20  # of a file; that of a turbine has less than 1 MB
YAML_LEVELS = 100  # of tables and lists in each other
VALUES = 2_000_000  # of a file with its aliases written out; a turbine has 60,000


def read_yaml(file: Path) -> Any:
    """Read a YAML file.

    Raises
    ------
    InputError
        PyYAML is missing; no such file; not YAML; too large; a key that a table has twice.
    """
    try:
        from yaml import YAMLError
    except ImportError as error:
        raise InputError("YAML files need PyYAML: pip install pyyaml") from error
    try:
        with file.open("rb") as stream:
            text = stream.read(BYTES + 1)
    except OSError as error:
        raise InputError(f"{file}: cannot be read: {error}") from error
    if len(text) > BYTES:
        raise InputError(f"{file}: not read: more than {BYTES // 2**20} MB")
    try:
        return _loaded(text)
    except (YAMLError, ValueError, AttributeError, LookupError) as error:  # also of PyYAML's tags
        where = " ".join(str(error).replace('in "<byte string>", ', "").split())
        if "exceeded maximum" in where:  # a limit of libyaml's own, from PyYAML 6.0.4 on
            where = f"more than {YAML_LEVELS} levels"
        raise InputError(f"{file}: not valid YAML: {where}") from error


MERGE = "tag:yaml.org,2002:merge"


def _merged_tables(node: Any) -> list[Any]:
    """Return the tables that a node merges. Raises ValueError."""
    tables = node.value if node.id == "sequence" else [node]
    if any(table.id != "mapping" for table in tables):
        line = node.start_mark.line + 1
        raise ValueError(f"line {line}: <<: expected a table, or a list of tables")
    return list(tables)


def _loaded(text: bytes) -> Any:
    import yaml
    from yaml.composer import Composer, ComposerError

    # libyaml's own composer calls itself for each level, without a limit.
    bases: tuple[type, ...] = (yaml.SafeLoader,)
    if yaml.__with_libyaml__:
        bases = (Composer, yaml.CSafeLoader)

    class Loader(*bases):  # type: ignore[misc]
        def __init__(self, stream: bytes) -> None:
            bases[-1].__init__(self, stream)  # type: ignore[misc]
            Composer.__init__(self)
            self.level = self.values = 0
            self.sizes: dict[str, int] = {}  # of the nodes with an anchor

        def compose_node(self, parent: Any, index: Any) -> Any:
            event = self.peek_event()
            before, anchor = self.values, event.anchor
            if isinstance(event, yaml.AliasEvent):
                if anchor in self.anchors and anchor not in self.sizes:
                    message = f"{anchor!r} contains itself"
                    raise ComposerError(None, None, message, event.start_mark)
                self.values += self.sizes.get(anchor, 0)
            elif anchor is not None:
                self.anchors.pop(anchor, None)
                self.sizes.pop(anchor, None)
            self.values += 1
            self.level += 1
            for count, most, what in (
                (self.level, YAML_LEVELS, "levels"),
                (self.values, VALUES, "values, aliases counted as what they stand for"),
            ):
                if count > most:
                    message = f"more than {most} {what}"
                    raise ComposerError(None, None, message, event.start_mark)
            node = super().compose_node(parent, index)
            self.level -= 1
            if anchor is not None:
                self.sizes[anchor] = self.values - before
            return node

        def compose_mapping_node(self, anchor: Any) -> Any:
            node = super().compose_mapping_node(anchor)
            marks: dict[Any, Any] = {}
            for key, _ in node.value:
                name = key.tag, str(key.value)
                if name in marks:
                    one, two = marks[name].line + 1, key.start_mark.line + 1
                    message = f"{key.value}: a key of line {one} and again of line {two}"
                    raise ComposerError(None, None, f"{message}; expected it once")
                marks[name] = key.start_mark
            return node

        def flatten_mapping(self, node: Any) -> None:
            """Merge tables (`<<`): own keys first, then the first table that has a key.

            PyYAML 6.0.4 compares keys by identity and takes others.
            """
            own = [pair for pair in node.value if pair[0].tag != MERGE]
            count = {(key.tag, str(key.value)): (key, value) for key, value in own}
            for key, value in node.value:
                for table in _merged_tables(value) if key.tag == MERGE else ():
                    self.flatten_mapping(table)
                    for pair in table.value:
                        count.setdefault((pair[0].tag, str(pair[0].value)), pair)
            node.value = list(count.values())

    loader = Loader(text)
    try:
        return loader.get_single_data()
    finally:
        loader.dispose()


# Text files with numbers in lines, such as those that spreadsheets write.


def read_text(file: Path) -> str:
    """Return the text of a file. Raises ValueError: no such file, or no text in UTF-8."""
    with _opened(file) as text:
        return text.read()


def lines_of(file: Path) -> Iterator[tuple[int, str]]:
    """Yield the lines of a file with their numbers, without empty lines and remarks after #.

    One line is in memory at a time. Raises ValueError as `read_text`.
    """
    with _opened(file) as text:
        for number, line in enumerate(text, start=1):
            if line.strip() and not line.lstrip().startswith("#"):
                yield number, line.rstrip("\n")


def numbered_lines(file: Path) -> list[tuple[int, str]]:
    """Return `lines_of` a file as a list."""
    return list(lines_of(file))


@contextlib.contextmanager
def _opened(file: Path) -> Iterator[TextIO]:
    try:
        if file.exists() and not file.is_file():  # a folder, or a device that never ends
            raise ValueError(f"{file}: cannot be read (expected a file)")
        with file.open(encoding="utf-8-sig") as text:
            yield text
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{file}: cannot be read ({error})") from error
