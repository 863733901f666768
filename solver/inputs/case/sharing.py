"""Members of a sweep in little memory: what they have in common exists once."""

from typing import Any

from .schema import Mechanism


def sharing(member: Mechanism, base: Mechanism) -> Mechanism:
    """Replace the parts of a member that are equal to those of `base` by the same objects.

    Parts are the fields of a mechanism, and the entries of its tables: bodies, joints, ...
    """
    for name in type(member).model_fields:
        own, common = getattr(member, name), getattr(base, name)
        if own is common:
            continue
        if own == common:
            member.__dict__[name] = common
        elif isinstance(own, dict) and isinstance(common, dict):
            own.update({key: _one(value, common.get(key)) for key, value in own.items()})
    return member


def _one(own: Any, common: Any) -> Any:
    return common if own == common else own
