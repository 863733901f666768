"""The map from the paper's equations to code and tests: equations.py docs/equations.md.

Collected from docstrings, where an implementation says `Paper: Eq. (13)`. The
grammar, which tests/contract/test_equations.py enforces:

    Paper: ITEM, ITEM and ITEM      ITEM is  Eq. (n)  or a range  Eq. (n)-(m)

Titles of the equations, and reasons for those that are not in the code, are
in docs/equations.toml. A test belongs to an equation if it contains `Eq. (n)`
in its docstring or comments, or uses the function that implements it.
"""

import ast
import re
import sys
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CODE = ("preprocess", "solver")
LAST = 45  # the paper numbers its equations from (1) to (45)
MOST_TESTS = 4  # named in one row of the table

ITEM = re.compile(r"Eq\. \((\d+)\)(?:-\((\d+)\))?")
MARK = re.compile(rf"Paper:\s+({ITEM.pattern}(?:(?:,|,?\s+and)\s+{ITEM.pattern})*)")
# Text after a well-formed list that looks like a part of it.
LEFTOVER = re.compile(r"\s*(?:,|-|–|and|to|/)?\s*(?:Eqs?\.)?\s*\(\d")


class GrammarError(Exception):
    """A docstring does not follow the grammar of references to the paper."""


@dataclass(frozen=True)
class Place:
    """Where an equation is implemented."""

    path: str  # from the repository's root, with /
    name: str  # function or class, with its class in front; "" for the module

    def __str__(self) -> str:
        """The place as the table shows it."""
        return self.path + (f" ({self.name})" if self.name else "")


def numbers(text: str) -> Iterator[int]:
    """Equation numbers that a text names, ranges expanded."""
    for match in ITEM.finditer(text):
        first = int(match[1])
        yield from range(first, int(match[2] or first) + 1)


def documented(tree: ast.Module) -> Iterator[tuple[ast.AST, str, int, str]]:
    """(node, qualified name, line, docstring) of a module and all it defines."""

    def walk(node: ast.AST, prefix: str) -> Iterator[tuple[ast.AST, str, int, str]]:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                name = f"{prefix}{child.name}"
                yield child, name, child.lineno, ast.get_docstring(child) or ""
                yield from walk(child, f"{name}.")

    yield tree, "", 1, ast.get_docstring(tree) or ""
    yield from walk(tree, "")


def places(root: Path = ROOT) -> dict[int, list[Place]]:
    """Equation number -> where the docstrings say it is implemented."""
    found: dict[int, list[Place]] = {}
    for path in sources(root, CODE):
        relative = path.relative_to(root).as_posix()
        text = path.read_text("utf-8")
        if "Paper:" not in text:
            continue  # parsing takes longer
        for _, name, line, docstring in documented(ast.parse(text)):
            for number in marked(docstring, f"{relative}:{line}"):
                place = Place(relative, name)
                if place not in found.setdefault(number, []):
                    found[number].append(place)
    return dict(sorted(found.items()))


def marked(docstring: str, where: str) -> Iterator[int]:
    """Numbers after `Paper:`; GrammarError if the form or a number is not agreed."""
    for start in re.finditer(r"Paper:", docstring):
        match = MARK.match(docstring, start.start())
        if match is None or LEFTOVER.match(docstring, match.end()):
            shown = " ".join(docstring[start.start() :].split())[:60]
            raise GrammarError(
                f'{where}: "{shown}": expected "Paper: Eq. (n)", '
                '"Paper: Eq. (n), Eq. (m)" or "Paper: Eq. (n)-(m)"'
            )
        for number in numbers(match[1]):
            if not 1 <= number <= LAST:
                raise GrammarError(f"{where}: the paper has no Eq. ({number}), only 1 to {LAST}")
            yield number


def sources(root: Path, folders: tuple[str, ...]) -> Iterator[Path]:
    """Python files under some folders of the repository, in order."""
    for folder in folders:
        yield from sorted((root / folder).rglob("*.py"))


def statements(tree: ast.AST) -> Iterator[ast.AST]:
    """All statements of a file; a walk through expressions as well takes ten times as long."""
    for child in ast.iter_child_nodes(tree):
        if isinstance(child, ast.stmt | ast.excepthandler | ast.match_case):
            yield child
            yield from statements(child)


def modules_imported(tree: ast.Module) -> str:
    """All modules and names that a file imports, as one text to search in."""
    words = []
    for node in statements(tree):
        if isinstance(node, ast.ImportFrom):
            words += [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            words += [alias.name for alias in node.names]
    return " ".join(words)


@dataclass(frozen=True)
class Test:
    """A test function: its name, the words it uses, the equations it carries."""

    name: str  # path::function
    imports: str  # what its file imports
    words: frozenset[str]  # identifiers in its body
    equations: frozenset[int]

    def uses(self, place: Place) -> bool:
        """True if this test's file imports from the place's module and it uses the name."""
        name = place.name.split(".")[0]
        if not name or name not in self.words:
            return False
        stem = Path(place.path).stem
        module = Path(place.path).parent.name if stem == "__init__" else stem
        known = re.search(rf"\b{re.escape(module)}\b", self.imports) is not None
        return known or re.search(rf"\.{re.escape(name)}\b", self.imports) is not None


def functions_of_tests(code: Iterable[Place], root: Path = ROOT) -> list[Test]:
    """All test functions of files that name an equation or a function of the code."""
    names = {place.name.split(".")[0] for place in code} - {""}
    needed = re.compile(rf"Eq\. \(|\b(?:{'|'.join(sorted(names))})\b")
    found = []
    for path in sources(root, ("tests",)):
        if not path.name.startswith("test_"):
            continue
        text = path.read_text("utf-8")
        if not needed.search(text):
            continue  # parsing takes longer
        lines = text.splitlines()
        tree = ast.parse(text)
        imports = modules_imported(tree)
        of_file = frozenset(numbers(ast.get_docstring(tree) or ""))
        for node, name, _, _ in documented(tree):
            if not isinstance(node, ast.FunctionDef) or not node.name.startswith("test"):
                continue
            words = {
                n.id if isinstance(n, ast.Name) else n.attr
                for n in ast.walk(node)
                if isinstance(n, ast.Name | ast.Attribute)
            }
            own = numbers("\n".join(lines[node.lineno - 1 : node.end_lineno]))
            label = f"{path.relative_to(root).as_posix()}::{name.replace('.', '::')}"
            found.append(Test(label, imports, frozenset(words), of_file | frozenset(own)))
    return found


def titles_and_reasons(root: Path = ROOT) -> tuple[dict[int, str], dict[int, str]]:
    """From docs/equations.toml: what each equation is, and why some have no code."""
    table = tomllib.loads((root / "docs" / "equations.toml").read_text("utf-8"))

    def expanded(section: str) -> dict[int, str]:
        result = {}
        for key, text in table.get(section, {}).items():
            first, _, last = key.partition("-")
            result.update(dict.fromkeys(range(int(first), int(last or first) + 1), text))
        return result

    return expanded("titles"), expanded("reasons")


def table(root: Path = ROOT) -> str:
    """The text of docs/equations.md."""
    code = places(root)
    tests = functions_of_tests((place for where in code.values() for place in where), root)
    titles, reasons = titles_and_reasons(root)
    lines = [
        "# From the paper's equations to code and tests",
        "",
        "Generated by `make docs` from the docstrings; the grammar is in CONTRIBUTING.md.",
        "Where the paper misprints an equation the code follows docs/errata.md.",
        "",
        "| Eq. | what | code | tests |",
        "|---|---|---|---|",
    ]
    for number in range(1, LAST + 1):
        where = code.get(number, [])
        names = [
            test.name
            for test in tests
            if number in test.equations or any(test.uses(place) for place in where)
        ]
        shown = names[:MOST_TESTS]
        if len(names) > MOST_TESTS:
            shown.append(f"and {len(names) - MOST_TESTS} more")
        cell = "<br>".join(map(str, where)) or f"none: {reasons.get(number, 'no reason given')}"
        row = (f"({number})", titles.get(number, ""), cell, "<br>".join(shown))
        lines.append("| " + " | ".join(row) + " |")
    return "\n".join(lines) + "\n"


def main(path: Path) -> int:
    """Write the table; exit code 1 if a docstring breaks the grammar."""
    try:
        text = table()
    except GrammarError as error:
        print(f"equations: {error}", file=sys.stderr)
        return 1
    temporary = path.with_name(path.name + ".part")
    temporary.write_text(text, "utf-8")
    temporary.replace(path)
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
