"""What case files and section descriptions share: TOML, tables, materials, messages, manual."""

from .messages import validated
from .table import Name, Table, entry, optional
from .text_file import read_toml

__all__ = ["Name", "Table", "entry", "optional", "read_toml", "validated"]
