"""Rules for functions that are compiled: no negative index, no array made inside."""

import ast

ROOMS = ("math", "dynamics", "integrators", "checks")
KINDS = {"lean", "jit", "inlined"}
MAKERS = {"array", "zeros", "empty", "ones", "eye", "full", "concatenate", "copy", "linspace"}


def _parts(text):
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.FunctionDef):
            continue
        marks = node.decorator_list
        # The body of a dispatched function is generated (math/catalogue.py).
        written = all(isinstance(mark, ast.Name) for mark in marks)
        if written and any(mark.id in KINDS for mark in marks):
            yield node


def _faults(text):
    """Compiled code neither looks for negative indices nor owns memory."""
    for part in _parts(text):
        for node in ast.walk(part):
            if isinstance(node, ast.Subscript):
                indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
                if any(_negative(index) for index in indices):
                    yield f"{part.name}: negative index in {ast.unparse(node)}"
            called = node.func if isinstance(node, ast.Call) else None
            if isinstance(called, ast.Attribute) and called.attr in MAKERS:
                yield f"{part.name}: {ast.unparse(node)} makes an array"
            if isinstance(node, ast.Raise | ast.Assert):
                yield f"{part.name}: {ast.unparse(node)}"


def _negative(index):
    ends = (index.lower, index.upper) if isinstance(index, ast.Slice) else (index,)
    return any(isinstance(end, ast.UnaryOp) and isinstance(end.op, ast.USub) for end in ends)


def test_parts_keep_to_the_rules(repository):
    found, count = [], 0
    for room in ROOMS:
        for path in sorted((repository / "solver" / room).rglob("*.py")):
            text = path.read_text(encoding="utf-8")
            if not any(f"@{kind}" in text for kind in KINDS):
                continue
            count += len(list(_parts(text)))
            found += [f"{path.relative_to(repository)}: {fault}" for fault in _faults(text)]
    assert count > 50
    assert not found, "\n".join(found)


def test_the_rules_find_what_they_forbid():
    text = (
        "@lean\ndef f(a):\n    b = np.zeros(3)\n    c = a[0, -1] + a[:-1]\n    raise ValueError\n"
        "def g(a):\n    return a[-1]\n"
    )
    assert len(list(_faults(text))) == 4


def test_numba_stays_behind_the_machinery(repository):
    """Numba and llvmlite are named in math/compiled only."""
    for path in sorted((repository / "solver").rglob("*.py")):
        if path.is_relative_to(repository / "solver" / "math" / "compiled"):
            continue
        text = path.read_text(encoding="utf-8")
        if "numba" not in text and "llvmlite" not in text:
            continue
        for node in ast.walk(ast.parse(text)):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(n.split(".")[0] in ("numba", "llvmlite") for n in names), path
