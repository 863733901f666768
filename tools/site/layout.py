"""Lay out the sources of the documentation site: layout.py FOLDER.

The pages of docs/ are plain Markdown that reads as well without the site. Here they get what the
site needs besides: README.md, CONTRIBUTING.md and CHANGELOG.md as pages, and one page for each file
of the repository that a page links to, so that each link of the site stays inside the site.
"""

import os
import re
import shutil
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = {  # of the repository, on the site; the index of docs/ is its first page
    "docs/README.md": "index.md",
    "README.md": "overview.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changes.md",
}
LANGUAGES = {".py": "python", ".toml": "toml", ".json": "json", ".sh": "sh", ".h": "c", ".c": "c"}
LINK = re.compile(r"(!?)\[([^][]*)\]\(([^)\s#]+)(#[^)\s]*)?\)")
CODE = re.compile(r"^( *)(```|~~~).*?^\1\2\s*$", re.MULTILINE | re.DOTALL)


def lay_out(folder: Path) -> None:
    """Write all sources of the site to `folder`; earlier ones are removed."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT / "docs", folder)
    for name in ("conf.py", "site.css"):
        shutil.copy(Path(__file__).parent / name, folder / name)
    (folder / "README.md").unlink()
    wanted: set[str] = set()
    pages = {f"docs/{p.relative_to(ROOT / 'docs')}" for p in (ROOT / "docs").rglob("*.md")}
    for name in sorted(pages | PAGES.keys()):
        page = PAGES.get(name, name.removeprefix("docs/"))
        _write(folder / page, ROOT / name, f"docs/{page}", wanted)
    _files(folder, wanted)
    (folder / "api.md").write_text(_api(), encoding="utf-8")
    with (folder / "index.md").open("a", encoding="utf-8") as index:
        index.write(_contents())


def _write(target: Path, source: Path, page: str, wanted: set[str]) -> None:
    """Write a page with its links turned to pages of the site; `page`: its place under the root."""
    text = source.read_text(encoding="utf-8")
    here = source.parent.relative_to(ROOT).as_posix()

    def turned(found: "re.Match[str]") -> str:
        sign, words, link, part = (
            found.group(1),
            found.group(2),
            found.group(3),
            found.group(4) or "",
        )
        if ":" in link:
            return found.group(0)
        path = os.path.normpath(os.path.join(here, link))
        if not sign and words.endswith(".md") and words.removesuffix(".md") in link:
            words = ""  # the site writes the title of the page
        return f"{sign}[{words}]({_relative(_place(path, wanted), page)}{part})"

    outside, at = [], 0
    for block in CODE.finditer(text):  # code is left as it is
        outside += [LINK.sub(turned, text[at : block.start()]), block.group(0)]
        at = block.end()
    outside.append(LINK.sub(turned, text[at:]))
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text("".join(outside), encoding="utf-8")


def _place(path: str, wanted: set[str]) -> str:
    """Where a file of the repository is on the site, as a path under the root."""
    if path in PAGES:
        return f"docs/{PAGES[path]}"
    if path.startswith("docs/") and (ROOT / path).is_file():
        return path
    wanted.add(path)
    return f"docs/files/{path}.md"


def _relative(path: str, page: str) -> str:
    return os.path.relpath(path, os.path.dirname(page)).replace(os.sep, "/")


def _api() -> str:
    """The page of the docstrings of all public names."""
    sys.path.insert(0, str(ROOT))
    import plymotion

    parts = ["# Names of `import plymotion`\n\n[](python.md) explains them by examples.\n"]
    for name in vars(plymotion)["__all__"]:
        found = getattr(plymotion, name)
        if name != "__version__":
            kind = "autoclass" if isinstance(found, type) else "autofunction"
            members = "   :members:\n" if isinstance(found, type) else ""
            parts.append(f"```{{eval-rst}}\n.. {kind}:: {found.__module__}.{name}\n{members}```\n")
    return "\n".join(parts)


def _contents() -> str:
    """The tables of contents, which the site shows beside each page."""
    parts = tomllib.loads((Path(__file__).parent / "contents.toml").read_text(encoding="utf-8"))
    return "".join(
        f"\n```{{toctree}}\n:caption: {caption}\n:hidden:\n:glob:\n\n"
        + "\n".join(pages)
        + "\n```\n"
        for caption, pages in parts.items()
    )


def _files(folder: Path, wanted: set[str]) -> None:
    """Write a page for each file, and for each folder with a list of its files."""
    listed = ["# Files that the pages refer to\n"]
    for path in sorted(wanted):
        source, target = ROOT / path, folder / "files" / f"{path}.md"
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            names = sorted(
                p.name + "/" * p.is_dir() for p in source.iterdir() if p.name[0] not in "._"
            )
            body = "\n".join(f"- `{name}`" for name in names)
        else:
            body = _fenced(source.read_text(encoding="utf-8"), source.suffix)
        target.write_text(f"---\norphan: true\n---\n\n# {path}\n\n{body}\n", encoding="utf-8")
        listed.append(f"- [{path}]({path}.md)")
    (folder / "files").mkdir(exist_ok=True)
    (folder / "files" / "index.md").write_text("\n".join(listed) + "\n", encoding="utf-8")


def _fenced(text: str, suffix: str) -> str:
    fence = "`" * max(3, 1 + max((len(run) for run in re.findall("`+", text)), default=0))
    return f"{fence}{LANGUAGES.get(suffix, 'text')}\n{text.rstrip()}\n{fence}"


if __name__ == "__main__":
    lay_out(Path(sys.argv[1]))
