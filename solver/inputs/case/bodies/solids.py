"""Solid bodies: their description and its checks."""

from pathlib import Path

from ....errors import InputError, under
from ....package.specification import SolidSpecification
from ...common import read_toml
from ...common.table import plain_table
from ...solid.expand import solid_table
from ..tables.modes import AttachmentChoice, ModeChoice, check_places
from ..tables.solid_schema import SolidBody


def solid_body_spec(
    name: str, body: SolidBody, folder: Path
) -> tuple[SolidSpecification, list[Path]]:
    """Return the specification of a solid, and the files beside the case file it is made from.

    Parameters
    ----------
    folder : of the case file, where relative paths start

    Raises
    ------
    InputError
        What is wrong with the body, one line each.
    """
    key, file = f"bodies.{name}", folder / body.solid
    try:
        table = read_toml(file, "solid description")
        # its own analysis is another one
        kept = {k: v for k, v in table.items() if k not in ("supports", "loads", "interfaces")}
        _, solid = solid_table(kept, file, body.size)
    except InputError as error:
        raise under(f"{key}.solid", error) from error
    if found := _check_motion(key, body):
        raise InputError("\n".join(found))
    spec: SolidSpecification = {
        "body": name,
        "kind": "solid",
        "solid": solid,
        "reference": plain_table(body.reference),
        "modes": [plain_table(mode) for mode in body.modes],
        "damping_ratio": body.damping_ratio,
        "interfaces": {k: plain_table(v) for k, v in body.interfaces.items()},
    }
    if body.second_order:
        spec["second_order"] = True
    return spec, [file, Path(solid["mesh"]["file"])]


def _check_motion(key: str, body: SolidBody) -> list[str]:
    """Return what is wrong with the interfaces that carry the frame, and with the modes."""
    found = check_places(key, body)
    found += [
        f'{key}.modes[{i}].kind = "{mode.kind}": expected "lowest" or "attachment": the modes of '
        "a solid"
        for i, mode in enumerate(body.modes)
        if not isinstance(mode, AttachmentChoice)
        and not (isinstance(mode, ModeChoice) and mode.kind == "lowest")
    ]
    return found
