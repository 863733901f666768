"""Write plymotion/api/builders.pyi: the functions of a case for editors and type checkers.

Usage: builder_stubs.py plymotion/api/builders.pyi
"""

import inspect
import sys
from pathlib import Path
from types import NoneType
from typing import Any, Literal, get_args, get_origin

from plymotion.api.builders import keys_of, kinds, signature_of, text_of
from plymotion.solver.inputs.common.input_table import Table, without_annotations


def stub() -> str:
    """Return the text of builders.pyi."""
    lines = [
        '"""Functions of a case; written by `make docs` from the tables of the case file."""',
        "",
        "import inspect",
        "from collections.abc import Iterator, Mapping, Sequence",
        "from typing import Any, Literal",
        "",
        "from ..solver.math.arrays import Array",
        "from .keys import Keys",
        "",
        "Number = float | str",
        "Vector = Sequence[float] | Array | str",
        "",
        "def kinds() -> Iterator[Any]: ...",
        "def keys_of(kind: Any) -> dict[str, Any]: ...",
        "def signature_of(kind: Any) -> inspect.Signature: ...",
        "def text_of(kind: Any) -> str: ...",
        "",
        "class Builders:",
        "    __slots__ = ()",
    ]
    for kind in kinds():
        lines += ["", f"    def {kind.name}("]
        fields = {**kind.model.model_fields, **keys_of(kind)}
        for parameter in signature_of(kind).parameters.values():
            name = parameter.name
            if name == "self":
                lines.append("        self,")
                continue
            star = parameter.kind is inspect.Parameter.KEYWORD_ONLY
            if star and "        *," not in lines[lines.index(f"    def {kind.name}(") :]:
                lines.append("        *,")
            said = "str" if name in ("name", "one", "two") else type_of(fields[name].annotation)
            optional = parameter.default is None
            if optional and "None" not in said and said != "Any":
                said += " | None"
            lines.append(f"        {name}: {said}{' = None' if optional else ''},")
        text = text_of(kind).replace("\\", "\\\\").splitlines()
        lines.append("    ) -> Keys:")
        lines.append(f'        """{text[0]}')
        lines += [f"        {line}".rstrip() for line in text[1:]]
        lines += ['        """']
    return "\n".join(lines) + "\n"


def type_of(annotation: Any) -> str:
    """Return the type of an argument as text."""
    kind = without_annotations(annotation)
    parts = [part for part in get_args(kind) if part is not NoneType]
    if NoneType in get_args(kind) and len(parts) == 1:
        return type_of(parts[0])
    if kind is float or kind is int:
        return "Number"
    if kind is str or kind is bool:
        return str(kind.__name__)
    origin = get_origin(kind)
    if origin is Literal:
        return f"Literal[{', '.join(map(repr, get_args(kind)))}]"
    if origin is list:
        inner = without_annotations(parts[0])
        return "Vector" if inner is float else "Sequence[str]" if inner is str else "Any"
    if origin is dict or (isinstance(kind, type) and issubclass(kind, Table)):
        return "Mapping[str, Any]"
    return "Any"


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(stub(), encoding="utf-8")
