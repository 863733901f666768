"""The content of a run file, build/CASE/runs/RUN.json, as plain data."""

from collections.abc import Iterator, Mapping
from typing import Any


def package_entries(table: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield file and digest of all packages that a run needs, other runs included."""
    yield from table["packages"].values()
    yield from table.get("check_packages", {}).values()
    for other in table.get("other_runs", {}).values():
        yield from other["packages"].values()
