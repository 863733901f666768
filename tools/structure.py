"""Measure the structure of solver/, preprocess/ and plymotion/; write the table of a page.

Usage: structure.py docs/architecture.md
"""

import ast
import io
import sys
import tokenize
from collections.abc import Callable, Iterator
from pathlib import Path

PARTS = ("solver", "preprocess", "plymotion")
BEGIN, END = "<!-- tools/structure.py: begin -->", "<!-- end -->"
WITHOUT_CODE = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
}
Graph = dict[str, set[str]]


def sources(root: Path) -> dict[str, str]:
    """Return the text of every source file by its path."""
    files = (path for part in PARTS for path in sorted((root / part).rglob("*.py")))
    return {path.relative_to(root).as_posix(): path.read_text("utf-8") for path in files}


def docstrings(tree: ast.Module) -> Iterator[ast.Expr]:
    """Yield the docstrings of a module, its classes and functions."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[0] if node.body else None
            if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
                yield first


def code_lines(text: str) -> int:
    """Return the number of lines without docstrings, comments and blanks."""
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in WITHOUT_CODE:
            lines.update(range(token.start[0], token.end[0] + 1))
    for node in docstrings(ast.parse(text)):
        lines -= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return len(lines)


def statements(inside: ast.AST) -> Iterator[ast.stmt]:
    """Yield the statements of a module at any depth; all nodes take five times as long."""
    for part in ("body", "handlers", "orelse", "finalbody", "cases"):
        for node in getattr(inside, part, ()):
            yield node
            yield from statements(node)


def imports(texts: dict[str, str], part: str) -> Graph:
    """Return file -> files of the same part that it imports, wherever the statement stands."""
    names = {name for name in texts if name.startswith(f"{part}/")}
    modules = {name.removesuffix(".py").removesuffix("/__init__"): name for name in names}
    graph: Graph = {name: set() for name in names}
    for name in names:
        folder = name.split("/")[:-1]
        for node in statements(ast.parse(texts[name])):
            if not isinstance(node, ast.ImportFrom) or not 0 < node.level <= len(folder):
                continue
            base = folder[: len(folder) - node.level + 1]
            module = "/".join([*base, *(node.module.split(".") if node.module else [])])
            for alias in node.names:
                target = modules.get(f"{module}/{alias.name}", modules.get(module))
                if target and target != name:
                    graph[name].add(target)
    return graph


def longest_chain(graph: Graph) -> int:
    """Return the number of nodes on the longest path of a graph without circles."""
    found: dict[str, int] = {}

    def visit(node: str) -> int:
        if node not in found:
            found[node] = 1 + max((visit(target) for target in graph[node]), default=0)
        return found[node]

    return max(map(visit, graph))


def rooms(graph: Graph, folder: str) -> Graph:
    """Return child -> children that it imports, for the files and folders of one folder."""
    depth = folder.count("/") + 1
    inside = {name for name in graph if name.startswith(f"{folder}/")}
    found: Graph = {name.split("/")[depth]: set() for name in inside}
    for name in inside:
        child = name.split("/")[depth]
        found[child] |= {t.split("/")[depth] for t in graph[name] & inside} - {child}
    return found


def folders(graph: Graph) -> list[str]:
    """Return every folder that has files below it."""
    return sorted({"/".join(n.split("/")[:k]) for n in graph for k in range(1, n.count("/") + 1)})


def modules_in(graph: Graph, folder: str) -> int:
    """Return the number of files directly in a folder, `__init__.py` apart."""
    files = (name.rpartition("/") for name in graph)
    return sum(where == folder and name != "__init__.py" for where, _, name in files)


def documented(texts: dict[str, str]) -> dict[str, bool]:
    """Return whether each public function of three or more arguments documents its parameters.

    It does if it has a section Parameters that names nothing but its arguments.
    """
    found: dict[str, bool] = {}

    def visit(file: str, inside: ast.Module | ast.ClassDef) -> None:
        for node in inside.body:
            if isinstance(node, ast.ClassDef | ast.FunctionDef) and node.name.startswith("_"):
                continue
            if isinstance(node, ast.ClassDef):
                visit(file, node)
            elif isinstance(node, ast.FunctionDef):
                given = node.args
                every = [*given.posonlyargs, *given.args, *given.kwonlyargs]
                every += [one for one in (given.vararg, given.kwarg) if one is not None]
                names = {one.arg for one in every} - {"self", "cls"}
                if len(names) >= 3:
                    known = _described(ast.get_docstring(node) or "")
                    found[f"{file}:{node.name}:{node.lineno}"] = bool(known) and known <= names

    for name, text in texts.items():
        visit(name, ast.parse(text))
    return found


def _described(text: str) -> set[str]:
    """Names in the section Parameters of a docstring."""
    lines = text.partition("Parameters\n----------\n")[2].partition("\n\n")[0].splitlines()
    heads = [line.partition(" :")[0] for line in lines if not line.startswith(" ")]
    return {name.strip(" *") for head in heads for name in head.split(",")}


def thresholds(texts: dict[str, str]) -> tuple[set[str], list[str]]:
    """Return what the sources compare numbers with, beside their tolerances.py.

    Module constants "file:NAME" that are no whole numbers, and literals "file:line" other than
    0, 1, 2 and a half, in comparisons by size.
    """
    trees = {name: ast.parse(text) for name, text in texts.items() if "tolerances" not in name}
    known = {name: _numbers(tree) for name, tree in trees.items()}
    constants, literals = set[str](), list[str]()
    for name, tree in trees.items():
        places = dict.fromkeys(known[name], name)
        folder = name.split("/")[:-1]
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.level:
                base = folder[: len(folder) - node.level + 1]
                file = "/".join([*base, *(node.module or "").split(".")]) + ".py"
                places |= {a.name: file for a in node.names if a.name in known.get(file, ())}
            if not isinstance(node, ast.Compare) or not _by_size(node):
                continue
            for part in ast.walk(node):
                if isinstance(part, ast.Name) and part.id in places:
                    constants.add(f"{places[part.id]}:{part.id}")
                if isinstance(part, ast.Constant) and isinstance(part.value, float):
                    literals += [f"{name}:{part.lineno}"] * (part.value not in (0.0, 0.5, 1.0, 2.0))
    return constants, literals


def _by_size(node: ast.Compare) -> bool:
    return any(isinstance(o, ast.Lt | ast.LtE | ast.Gt | ast.GtE) for o in node.ops)


def _numbers(tree: ast.Module) -> set[str]:
    """Names that a module gives to numbers that are no whole numbers."""
    found = set[str]()
    for node in tree.body:
        if isinstance(node, ast.Assign):
            for target, value in _pairs(node.targets[0], node.value):
                parts = list(ast.walk(value))
                plain = all(isinstance(p, _ARITHMETIC) for p in parts)
                if plain and any(isinstance(getattr(p, "value", 0), float) for p in parts):
                    found.add(target)
    return found


def _pairs(target: ast.expr, value: ast.expr) -> Iterator[tuple[str, ast.expr]]:
    if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        for one, number in zip(target.elts, value.elts, strict=True):
            yield from _pairs(one, number)
    elif isinstance(target, ast.Name):
        yield target.id, value


_ARITHMETIC = (ast.Constant, ast.UnaryOp, ast.BinOp, ast.operator, ast.unaryop)


def table(root: Path) -> str:
    """Return the table of the page in Markdown."""
    texts = sources(root)
    code = {name: code_lines(text) for name, text in texts.items()}
    by_part = {part: sum(code[n] for n in code if n.startswith(f"{part}/")) for part in PARTS}
    graphs = {part: imports(texts, part) for part in PARTS[:2]}
    levels = longest_chain(rooms(graphs["solver"], "solver"))
    chains = ", ".join(f"{longest_chain(graph)} in {part}/" for part, graph in graphs.items())
    known = documented(texts)
    large = {
        folder: modules_in(graph, folder)
        for graph in graphs.values()
        for folder in folders(graph)
        if modules_in(graph, folder) > 12
    }
    rows = [
        (
            "lines of code, without docstrings, comments and blanks",
            f"{sum(code.values())}: " + ", ".join(f"{n} in {part}/" for part, n in by_part.items()),
        ),
        (
            "files; of 30 lines of code or fewer",
            f"{len(code)}; {sum(n <= 30 for n in code.values())}",
        ),
        ("levels of solver/", str(levels)),
        ("longest chain of imports, file by file", chains),
        (
            "folders of more than 12 modules",
            ", ".join(f"{name} {n}" for name, n in sorted(large.items())),
        ),
        ("`dict[str, Any]`", str(sum(text.count("dict[str, Any]") for text in texts.values()))),
        (
            "public functions of three or more arguments; their parameters documented",
            f"{len(known)}; {sum(known.values())}",
        ),
    ]
    lines = ["| measure | value |", "|---|---|", *(f"| {name} | {value} |" for name, value in rows)]
    return "\n".join(lines)


def write(begin: str, end: str, table: Callable[[Path], str]) -> None:
    """Write a table of the repository between two marks in the page that the command names."""
    page = Path(sys.argv[1])
    before, _, rest = page.read_text("utf-8").partition(begin)
    _, _, after = rest.partition(end)
    text = f"{before}{begin}\n{table(Path(__file__).resolve().parents[1])}\n{end}{after}"
    page.write_text(text, "utf-8")


if __name__ == "__main__":
    write(BEGIN, END, table)
