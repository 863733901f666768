"""Text files: lines of those that cases name, TOML of another kind than expected."""

import pytest

from plymotion.solver.__main__ import main
from plymotion.solver.inputs.case.tables.laws import PythonCode, read_columns
from plymotion.solver.inputs.common.text_file import numbered_lines


def test_lines_keep_their_numbers(tmp_path):
    file = tmp_path / "lines.csv"
    file.write_text("# remark\n\n0, 1\n  # indented\n1, 2\n")
    assert numbered_lines(file) == [(3, "0, 1"), (5, "1, 2")]


def test_a_mark_of_utf8_is_no_part_of_the_first_number(tmp_path):
    """Spreadsheets write the mark before the first line."""
    file = tmp_path / "columns.csv"
    file.write_text("0.0, 1.0\n1.0, 2.0\n", encoding="utf-8-sig")
    assert read_columns(file) == ([0.0, 1.0], [1.0, 2.0])


def test_code_of_a_controller_is_no_device(tmp_path):
    (tmp_path / "zero.py").symlink_to("/dev/zero")
    with pytest.raises(ValueError, match=r"zero\.py: cannot be read .expected a file"):
        PythonCode.model_validate({"file": "zero.py"}, context={"folder": tmp_path})


def test_a_file_of_another_kind_is_one_message(capsys):
    case, section = "cases/double-pendulum/case.toml", "cases/sections/square.toml"
    for words, told in (
        (["section", case], f"{case}: expected a section description, found a case file"),
        (["shell", case], f"{case}: expected a shell description, found a case file"),
        (["check", section], f"{section}: expected a case file, found a description for"),
    ):
        assert main(words) == 2
        assert capsys.readouterr().err.count(told) == 1
