"""Count the lines of each capability of tools/capabilities.toml; write the table of a page.

Usage: capabilities.py docs/capabilities.md
"""

import ast
import io
import tokenize
import tomllib
from collections import Counter
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import structure

BEGIN, END = "<!-- tools/capabilities.py: begin -->", "<!-- end -->"
HEAD = ["capability", "lines", "importers", "used by", "simpler form, and its loss", "saves"]


def code_rows(text: str) -> set[int]:
    """Return the numbers of the lines that `structure.code_lines` counts."""
    rows: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in structure.WITHOUT_CODE:
            rows.update(range(token.start[0], token.end[0] + 1))
    for node in structure.docstrings(ast.parse(text)):
        rows -= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return rows


def parts_of(text: str, names: list[str]) -> set[int]:
    """Return the lines of functions and classes of a file."""
    rows: set[int] = set()
    known: dict[str, Any] = {n.name: n for n in ast.parse(text).body if hasattr(n, "name")}
    for name in names:
        node = known[name]
        rows |= set(range(node.lineno, node.end_lineno + 1))
    return rows


def shares(
    groups: list[dict[str, Any]], texts: dict[str, str]
) -> tuple[Counter[str], dict[str, str]]:
    """Return the lines of each row by its name, and the row of each whole file.

    Raises SystemExit for a file without a row.
    """
    left = {file: code_rows(text) for file, text in texts.items()}
    lines: Counter[str] = Counter()
    owner: dict[str, str] = {}
    rows = [row for group in groups for row in group["row"]]
    for row in rows:
        for pattern in row["files"]:
            file, colons, names = pattern.partition("::")
            if colons:
                own = left[file] & parts_of(texts[file], names.split())
                lines[row["name"]] += len(own)
                left[file] -= own
    patterns = [(p, row["name"]) for row in rows for p in row["files"] if "::" not in p]
    for file in texts:
        fitting = [pair for pair in patterns if fnmatchcase(file, pair[0])]
        if fitting:
            owner[file] = max(fitting, key=lambda pair: len(pair[0]))[1]
            lines[owner[file]] += len(left[file])
    if without := sorted(texts.keys() - owner.keys()):
        raise SystemExit(f"tools/capabilities.toml: no row for {', '.join(without)}")
    return lines, owner


def importers(texts: dict[str, str]) -> structure.Graph:
    """Return file -> files that it imports, across the parts: the halves are below plymotion/."""
    below = {f if f.startswith("plymotion/") else f"plymotion/{f}": t for f, t in texts.items()}
    own = {name: name if name in texts else name.removeprefix("plymotion/") for name in below}
    graph = structure.imports(below, "plymotion")
    return {own[name]: {own[target] for target in targets} for name, targets in graph.items()}


def composition(texts: dict[str, str]) -> str:
    """Return what the lines of code are, in words."""
    found: Counter[str] = Counter()
    for text in texts.values():
        own: dict[str, set[int]] = {"imports": set(), "heads": set(), "messages": set()}
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Import | ast.ImportFrom):
                own["imports"] |= set(range(node.lineno, (node.end_lineno or 0) + 1))
            elif isinstance(node, ast.FunctionDef | ast.ClassDef):
                found["functions"] += 1
                first = min([node.lineno, *(d.lineno for d in node.decorator_list)])
                own["heads"] |= set(range(first, node.body[0].lineno))
            elif isinstance(node, ast.Raise):
                own["messages"] |= set(range(node.lineno, (node.end_lineno or 0) + 1))
        rows = code_rows(text)
        for what, lines in own.items():
            found[what] += len(lines & rows)
    return (
        f"Of these lines {found['imports']} are imports, {found['heads']} heads of the "
        f"{found['functions']} functions and classes, {found['messages']} errors that are raised."
    )


def table(root: Path) -> str:
    """Return the tables of the page in Markdown."""
    groups = tomllib.loads((root / "tools/capabilities.toml").read_text("utf-8"))["group"]
    texts = structure.sources(root)
    lines, owner = shares(groups, texts)
    users: dict[str, set[str]] = {}
    for file, targets in importers(texts).items():
        for target in targets:
            if owner[target] != owner[file]:
                users.setdefault(owner[target], set()).add(file)
    out: list[str] = []
    saved: Counter[str] = Counter()
    for group in groups:
        total = sum(lines[row["name"]] for row in group["row"])
        out += ["", f"### {group['name']}: {total} lines", ""]
        out += ["| " + " | ".join(HEAD) + " |", "|---" * len(HEAD) + "|"]
        for row in group["row"]:
            count = lines[row["name"]]
            saves = max(0, count - row.get("left", count))
            saved[row.get("loss", "")] += saves
            cells = [row["name"], str(count), str(len(users.get(row["name"], ()))), row["used"]]
            cells += [row.get("simpler", "core"), f"{saves} {row['loss']}" if saves else ""]
            out.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    words = ", ".join(f"{saved[loss]} by those of class {loss}" for loss in "ABC")
    top = f"{sum(lines.values())} lines in {len(texts)} files. {composition(texts)}"
    top += f" All simpler forms would save {sum(saved.values())} lines: {words}."
    return "\n".join([top, *out])


if __name__ == "__main__":
    structure.write(BEGIN, END, table)
