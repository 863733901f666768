"""Refuse HDF5 files that read other files: a file from elsewhere is read alone.

Hard links and virtual datasets of the file itself are followed, nothing else is.
"""

from pathlib import Path

import h5py

SMALL = 200_000_000  # bytes that any file may have
PACKED = 1100  # bytes of data in a byte of a file: more than gzip can pack


def refuse_foreign_parts(path: Path, file: h5py.File, error: type[Exception]) -> None:
    """Raise `error` for the first link, storage or source outside the file, or soft link.

    Also for more data than a file of its size can hold: arrays that nobody has written, or packed
    twice, would fill the memory with a single value.
    """
    seen: set[int] = set()
    room = max(SMALL, PACKED * path.stat().st_size)

    def visit(group: h5py.Group) -> None:
        nonlocal room
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
                address = h5py.h5o.get_info(item.id).addr
                room -= item.nbytes if address not in seen else 0
                seen.add(address)
                if room < 0:
                    raise error(f"{where}: {item.nbytes} bytes, more than this file can hold")
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
