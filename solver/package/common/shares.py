"""Equal shares of a list of section specifications, the same on every machine.

Sections of one mesh stay together, so that meshing, numbering and ordering
of unknowns are done once.
"""

import argparse
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeVar

from .plain_data import canonical

Item = TypeVar("Item")


def mesh_key(spec: Mapping[str, Any]) -> str:
    """Text that is equal for specifications of equal meshes."""
    return canonical(spec.get("mesh"))


def by_mesh(items: Iterable[tuple[Item, str]]) -> list[list[Item]]:
    """Groups of items of equal mesh, from (item, `mesh_key`); all in order of appearance."""
    groups: dict[str, list[Item]] = {}
    for item, key in items:
        groups.setdefault(key, []).append(item)
    return list(groups.values())


def share(items: Sequence[Item], part: tuple[int, int]) -> list[Item]:
    """The k-th of N contiguous shares, part = (k, N) with k from 1; together they are complete."""
    k, n = part
    return list(items[len(items) * (k - 1) // n : len(items) * k // n])


def shard(text: str) -> tuple[int, int]:
    """(k, N) of the option --shard k/N."""
    k, slash, n = text.partition("/")
    if slash and k.isdecimal() and n.isdecimal() and 1 <= int(k) <= int(n):
        return int(k), int(n)
    raise argparse.ArgumentTypeError(f"{text!r}: expected k/N with k from 1 to N, such as 2/8")
