"""The task of a worker that has a file made: what it says when the preprocessor does not start."""

import os

import pytest

from plymotion.solver.commands.fenicsx_side import task
from plymotion.solver.errors import InputError


@pytest.mark.skipif(os.name == "nt", reason="a script without suffix does not run there")
def test_a_preprocessor_that_does_not_start_is_named(tmp_path, monkeypatch):
    """Also by a worker of dask, which finds its own Python."""
    python = tmp_path / "python"
    python.write_text("#!/bin/sh\necho broken >&2\nexit 2\n")
    python.chmod(0o755)
    monkeypatch.setattr(task, "_found", lambda: str(python))
    start = task.Start("", "body", ())
    with pytest.raises(InputError, match=f"^{python}: the preprocessor does not run: "):
        task.make(start, tmp_path / "body.json")
