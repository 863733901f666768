"""The file of a case and its name. Nothing is read and no library is imported here."""

from pathlib import Path

from ...errors import InputError

CASE_FILE = "case.toml"


def case_file(path: Path) -> Path:
    """Return a case file; of a folder, the case.toml in it."""
    return path / CASE_FILE if path.is_dir() else path


def case_name(file: Path) -> str:
    """Return the name of the folder of a case.toml; of another file its own."""
    if file.stem in (".", ".."):  # "...toml": build/.. would be the folder of its files
        raise InputError(f"{file}: expected a file with a name before its ending")
    return file.resolve().parent.name if file.name == CASE_FILE else file.stem
