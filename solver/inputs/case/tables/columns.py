"""Columns of numbers in a case: lists, or packed where they are long.

A run file holds all that a run needs, the points of its tables too. Columns that come from a file
and are long are kept as text (math/rows.py), in memory too.
"""

from array import array
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, PlainSerializer, ValidationInfo, WrapValidator, model_validator

from ....math.rows import PREFIX, Packed, column, packed
from ...common.table import Table, entry, optional
from ...common.text_file import lines_of, read_text

# Keys of the validation context: the folder of the case file; whether tables are read already.
FOLDER, RESOLVED = "folder", "resolved"
LONG = 10_000  # rows from which on a column from a file is packed


def _kept(value: Any, check: Callable[[Any], Any], info: ValidationInfo) -> Any:
    """Leave a packed column as it is: one of a user's file is none."""
    resolved = bool((info.context or {}).get(RESOLVED))
    if isinstance(value, Packed) or (
        resolved and isinstance(value, str) and value.startswith(PREFIX)
    ):
        column(value)
        return value
    return check(value)


Times = Annotated[
    list[float], Field(min_length=2), WrapValidator(_kept), PlainSerializer(lambda value: value)
]


def read_columns(file: Path) -> tuple["list[float] | Packed", "list[float] | Packed"]:
    """Read times and values from a text file; header lines are ignored.

    Raises ValueError : no such file, a line without two numbers.
    """
    columns = array("d"), array("d")
    for number, line in lines_of(file):
        try:
            time, value = line.split(",")
            numbers = float(time), float(value)
        except ValueError as error:
            if not columns[0] and not any(letter.isdigit() for letter in line.split(",")[0]):
                continue  # names of the columns
            raise ValueError(
                f"{file} line {number}: expected two numbers with a comma, found {line.strip()!r}"
            ) from error
        columns[0].append(numbers[0])
        columns[1].append(numbers[1])
    if len(columns[0]) < LONG:
        return columns[0].tolist(), columns[1].tolist()
    return packed(np.frombuffer(columns[0])), packed(np.frombuffer(columns[1]))


class PythonCode(Table):
    """`code` of a controller written in Python.

    `def NAME(t, inputs, memory)` returns the force. t [s] is the instant, `inputs` an array of the
    values of `inputs`, `memory` a dictionary that is kept from call to call and empty at the start.
    The file is read, not executed, when the case is checked. NumPy and Python's own modules can be
    imported.
    """

    file: str = entry("Python file; path relative to the case file")
    function: str = entry("name of the function", default="control")
    source: str | None = optional("filled with the text of the file")

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any, info: ValidationInfo) -> Any:
        context = info.context or {}
        if context.get(RESOLVED) or not isinstance(data, dict):
            return data
        if "source" in data:
            raise ValueError("expected `file` and `function` only; found `source`")
        if not isinstance(data.get("file"), str):
            return data
        file = Path(context.get(FOLDER, ".")) / data["file"]
        return {**data, "source": read_text(file)}
