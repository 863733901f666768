"""No two places of solver/ and preprocess/ share twelve lines: one piece of code serves both."""

from collections import defaultdict
from pathlib import Path

MOST = 11  # lines in a row that two places may share
Places = list[tuple[str, int]]  # file and number of the first line


def code_lines(path: Path) -> list[tuple[int, str]]:
    """Numbers and text, without indentation, of lines that hold more than a bracket or import."""
    found, importing = [], False
    for number, line in enumerate(path.read_text("utf-8").splitlines(), 1):
        text = line.strip()
        importing = importing or text.startswith(("import ", "from "))
        if text.strip("()[]{},") and not importing:
            found.append((number, text))
        if importing and (")" in text or ("(" not in text and not text.endswith(","))):
            importing = False
    return found


def shared_runs(root: Path, folders: tuple[str, ...], size: int) -> dict[tuple[str, ...], Places]:
    """Places where the same `size` lines follow each other."""
    places: dict[tuple[str, ...], Places] = defaultdict(list)
    for folder in folders:
        for path in sorted((root / folder).rglob("*.py")):
            lines = code_lines(path)
            for first in range(len(lines) - size + 1):
                window = lines[first : first + size]
                text = tuple(line for _, line in window)
                places[text].append((path.relative_to(root).as_posix(), window[0][0]))
    return {text: found for text, found in places.items() if len(found) > 1}


def test_no_twelve_lines_stand_twice(repository: Path) -> None:
    found = shared_runs(repository, ("solver", "preprocess"), MOST + 1)
    told = {" and ".join(f"{file}:{line}" for file, line in places) for places in found.values()}
    assert not told, "the same lines: " + "; ".join(sorted(told))


def test_runs_are_found(tmp_path: Path) -> None:
    lines = [f"x{k} = {k}" for k in range(12)]
    (tmp_path / "a").mkdir()
    (tmp_path / "a/one.py").write_text("import os\n\n" + "\n".join(lines) + "\n")
    indented = "\n\n".join(f"    {line}" for line in lines)
    (tmp_path / "a/two.py").write_text(f"from b import (\n    c,\n)\n\ndef f():\n{indented}\n")
    (places,) = shared_runs(tmp_path, ("a",), 12).values()
    assert places == [("a/one.py", 3), ("a/two.py", 6)]
    (tmp_path / "a/two.py").write_text("\n".join(lines[:11]) + "\n")
    assert not shared_runs(tmp_path, ("a",), 12)
