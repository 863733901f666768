"""Descriptions that a case uses: in a file or in the case, with other values at some keys."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from ...common import read_toml
from ...common.table import plain_table
from ...section.description import checked as checked_section
from ...section.study import changed
from ...shell.description import checked as checked_shell

if TYPE_CHECKING:
    from ..tables.body_schema import ShellBody
    from ..tables.schema import Mechanism
    from ..tables.section_schema import DescribedSection

INLINE = "description"


def section_table(
    name: str, section: "DescribedSection", mechanism: "Mechanism", folder: Path
) -> tuple[dict[str, Any], Path]:
    """Return the description of a section, and its file; of one in the case, a name beside it.

    Raises
    ------
    InputError
        No such file; a change of a key that does not exist.
    """
    if section.file is not None:
        file = folder / section.file
        table = read_toml(file, "section description")
    else:
        file = folder / INLINE
        known = {name: plain_table(each) for name, each in mechanism.materials.items()}
        table = {"format": 1, "title": name, **(section.description or {})}
        own = table.get("materials", {})
        table["materials"] = {**known, **own} if isinstance(own, dict) else own
    return changed(table, section.changes, file), file


def shell_table(body: "ShellBody", folder: Path) -> tuple[dict[str, Any], Path]:
    """Return the description of a shell, and its file.

    Raises
    ------
    InputError
        No such file; a change of a key that does not exist.
    """
    file = folder / body.shell
    return changed(read_toml(file, "shell description"), body.changes, file), file


def described(way: list[str], mechanism: "Mechanism", folder: Path) -> BaseModel | None:
    """Return the model of the description that the table at `way` has, None without one.

    Raises
    ------
    InputError
        A description that is wrong.
    """
    group, name, *more = way
    if more or group not in ("sections", "bodies"):
        return None
    owner: Any = getattr(mechanism, group).get(name)
    if getattr(owner, "changes", None) is None:
        return None
    if group == "sections":
        return checked_section(*section_table(name, owner, mechanism, folder))
    table, file = shell_table(owner, folder)
    return checked_shell({**table, "frequencies": table.get("frequencies", {})}, file)
