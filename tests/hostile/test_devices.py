"""A path to a device that never ends is refused at once."""

import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.tables.laws import read_columns
from plymotion.solver.inputs.common.text_file import read_toml


def test_devices_are_no_files(tmp_path):
    link = tmp_path / "zero"
    link.symlink_to("/dev/zero")
    with pytest.raises(InputError, match="zero: no such case file"):
        read_toml(link, "case file")
    with pytest.raises(ValueError, match="zero: cannot be read"):
        read_columns(link)
