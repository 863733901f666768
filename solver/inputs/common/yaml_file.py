"""YAML files as plain tables.

Sizes are bounded while the file is read: a few bytes of YAML can mean any number of levels, or,
by aliases of aliases, of values. Reused anchors mean the last one, as in windIO's reader; a key
that a table has twice is an error.
"""

from pathlib import Path
from typing import Any

from ...errors import InputError

BYTES = 64 * 2**20  # of a file; that of a turbine has less than 1 MB
LEVELS = 100  # of tables and lists in each other
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
        raise InputError("YAML files need PyYAML: pip install 'plymotion[blade]'") from error
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
        raise InputError(f"{file}: not valid YAML: {where}") from error


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
                    words = f"{anchor!r} contains itself"
                    raise ComposerError(None, None, words, event.start_mark)
                self.values += self.sizes.get(anchor, 0)
            elif anchor is not None:
                self.anchors.pop(anchor, None)
                self.sizes.pop(anchor, None)
            self.values += 1
            self.level += 1
            for found, most, what in (
                (self.level, LEVELS, "levels"),
                (self.values, VALUES, "values, aliases counted as what they stand for"),
            ):
                if found > most:
                    words = f"more than {most} {what}"
                    raise ComposerError(None, None, words, event.start_mark)
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
                    words = f"{key.value}: a key of line {one} and again of line {two}"
                    raise ComposerError(None, None, f"{words}; expected it once")
                marks[name] = key.start_mark
            return node

    loader = Loader(text)
    try:
        return loader.get_single_data()
    finally:
        loader.dispose()
