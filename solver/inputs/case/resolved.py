"""The resolved mechanism of a run: plain data in a file, typed in the program."""

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from ...errors import InputError
from ..common.messages import lines
from .columns import RESOLVED
from .dotted_keys import put
from .outputs import output_findings
from .schema import Mechanism


def resolved(table: Mapping[str, Any], where: str) -> Mechanism:
    """Return the mechanism of a run or sweep file, as `check` wrote it.

    Raises
    ------
    InputError
        A file that was not written by `check`, or by another version; `where` names it.
    """
    try:
        found = Mechanism.model_validate(table, context={RESOLVED: True})
    except ValidationError as error:
        raise InputError("\n".join(lines(error, Mechanism, where))) from error
    if wrong := output_findings(found):
        raise InputError("\n".join(f"{where}: {line}" for line in wrong))
    return found


def changed_mechanism(mechanism: Mechanism, changes: Mapping[str, Any]) -> Mechanism:
    """Return a mechanism with other values at dotted keys, checked like one from a file."""
    return resolved(put(mechanism.model_dump(), changes), "changed mechanism")
