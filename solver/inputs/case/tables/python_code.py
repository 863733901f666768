"""`code` of a python_controller: a function in a file, read when the case is checked."""

from pathlib import Path
from typing import Any

from pydantic import ValidationInfo, model_validator

from ...common.table import Table, entry, optional
from ...common.text_file import read_text
from .columns import FOLDER, RESOLVED


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
