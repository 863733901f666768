"""Refuse HDF5 files that read other files: a file from elsewhere is read alone.

Hard links and virtual datasets of the file itself are followed, nothing else is.
"""

from pathlib import Path

import h5py


def refuse_foreign_parts(path: Path, file: h5py.File, error: type[Exception]) -> None:
    """Raise `error` for the first link, storage or source outside the file, or soft link."""
    seen: set[int] = set()

    def visit(group: h5py.Group) -> None:
        for name in group:
            link = group.get(name, getlink=True)
            where = f"{path}: {group.name.rstrip('/')}/{_text(name)}"
            if not isinstance(link, h5py.HardLink):
                kind = {h5py.ExternalLink: "a link to another file", h5py.SoftLink: "a soft link"}
                found = kind.get(type(link), "a link of another kind")
                raise error(f"{where}: expected data in the file itself, found {found}")
            item = group.get(name)
            if isinstance(item, h5py.Dataset):
                _dataset(where, item, error)
            elif isinstance(item, h5py.Group):
                address = h5py.h5o.get_info(item.id).addr
                if address not in seen:
                    seen.add(address)
                    visit(item)

    seen.add(h5py.h5o.get_info(file["/"].id).addr)
    visit(file)


def _dataset(where: str, dataset: h5py.Dataset, error: type[Exception]) -> None:
    if dataset.external:
        raise error(f"{where}: expected data in the file itself, found storage in another file")
    if dataset.is_virtual:
        for source in dataset.virtual_sources():
            if source.file_name != ".":
                text = f"found a virtual dataset of the file {source.file_name!r}"
                raise error(f"{where}: expected data in the file itself, {text}")


def _text(name: str | bytes) -> str:
    return name if isinstance(name, str) else name.decode("utf-8", "backslashreplace")
