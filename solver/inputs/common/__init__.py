"""What case files and section descriptions share: TOML, tables, materials, messages, manual."""

from .messages import validated
from .table import Name, Table, entry
from .text_file import read_toml

__all__ = ["Name", "Table", "entry", "read_toml", "validated"]
