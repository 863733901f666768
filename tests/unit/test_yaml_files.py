"""YAML files: keys once, and sizes that are bounded before anything is built."""

import pytest

from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.common import text_file
from plymotion.solver.inputs.common.text_file import read_yaml


def growing(levels: int) -> str:
    """Lists of nine aliases of the list before: nine times as many values a line."""
    lines = ["a0: &a0 [1, 2, 3, 4, 5, 6, 7, 8, 9]"]
    for k in range(1, levels):
        lines.append(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]")
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: 1\nb:\n  c: 1\n  d: 2\n  c: 3\n", "c: a key of line 3 and again of line 5"),
        ("{x: 1, 'x': 2}", "x: a key of line 1 and again of line 1"),
        ("[" * 200_000, "more than 100 levels"),
        ("{a: " * 50_000, "more than 100 levels"),
        ("- " * 100_000, "more than 100 levels"),
        (growing(12), "more than 2000000 values"),
        ("a: &a [*a]", "'a' contains itself"),
        ("a: &a {<<: *a}", "'a' contains itself"),
        ("a: !!python/object:os.system x", "could not determine a constructor"),
        ("a: !!timestamp x", "not valid YAML"),
        ("a: !!int ''", "not valid YAML"),
        ("? [1]\n: 2", "unhashable key"),
        ("a: \0", "control characters"),
        ("a: " + "9" * 5000, "not valid YAML"),
    ],
)
def test_what_cannot_be_read_is_named_at_once(tmp_path, capsys, text, words):
    file = tmp_path / "blade.yaml"
    file.write_text(text, encoding="utf-8")
    assert main(["blade", str(file), "--check", "-o", str(tmp_path / "out")]) == 2
    message = capsys.readouterr().err
    assert message.startswith(f"error: {file}: not valid YAML: ")
    assert words in message


def test_plain_aliases_merges_and_reused_anchors_are_read(tmp_path):
    """A reused anchor means the last one, as in windIO's reader; merged keys may be there again."""
    file = tmp_path / "one.yaml"
    file.write_text(
        "a: &grid [0, 1]\nb: *grid\nc: &grid [2]\nd: *grid\n"
        "e: &e {x: 1}\nf: &f\n  <<: *e\n  x: 2\ng: {<<: *f, y: 3}\n"
    )
    found = read_yaml(file)
    assert [found[key] for key in "bd"] == [[0, 1], [2]]
    assert found["f"] == {"x": 2}
    assert found["g"] == {"x": 2, "y": 3}
    file.write_text(
        "one: &one {width: 1}\ntwo: &two {width: 2, z: 3}\nh: {<<: [*one, *two], q: 0}\n"
    )
    assert read_yaml(file)["h"] == {"width": 1, "z": 3, "q": 0}
    file.write_text("a: {<<: 3}\n")
    with pytest.raises(InputError, match="<<: expected a table"):
        read_yaml(file)
    file.write_text(growing(5))
    assert len(read_yaml(file)["a4"]) == 9


def test_a_file_that_is_too_large_is_not_read(tmp_path, monkeypatch):
    file = tmp_path / "large.yaml"
    file.write_text("a: 1\n")
    monkeypatch.setattr(text_file, "BYTES", 4)
    with pytest.raises(InputError, match="not read: more than"):
        read_yaml(file)
