"""Turn pydantic's findings into one line each: file, key, value, what was expected."""

from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError

from ..errors import nearest


def lines(error: ValidationError, model: type[BaseModel], where: str) -> list[str]:
    """Return one message per finding of `error`; `where` names file and run."""
    found = []
    for item in error.errors():
        location = [p for p in item["loc"] if not _is_tag(p, item)]
        key = ".".join(str(p) for p in location)
        kind, value = item["type"], item.get("input")
        if kind == "extra_forbidden":
            hint = nearest(str(location[-1]), _siblings(model, item["loc"][:-1]))
            found.append(f"{where}: {key}: unknown key{hint}")
        elif kind == "missing":
            found.append(f"{where}: {key}: missing; expected a value")
        elif kind == "union_tag_not_found":
            found.append(f"{where}: {key}.{_tag(item)}: missing; expected one of {_tags(item)}")
        elif kind == "union_tag_invalid":
            tag = item["ctx"]["tag"]
            names = [n.strip(" '") for n in str(item["ctx"]["expected_tags"]).split(",")]
            found.append(
                f'{where}: {key}.{_tag(item)} = "{tag}": expected one of {_tags(item)}'
                + (nearest(tag, names) if nearest(tag, names).startswith("; did") else "")
            )
        else:
            text = item["msg"].removeprefix("Value error, ")
            text = text[0].lower() + text[1:]
            found.append(f"{where}: {key} = {_short(value)}: {text.replace('input', 'value')}")
    return sorted(set(found))


def _is_tag(part: Any, item: Any) -> bool:
    """Tell the names of union members, which pydantic puts into the path, from keys."""
    tags = {"beam", "rigid", "package", "isotropic", "orthotropic", "rectangle", "ellipse"}
    tags |= {"revolute", "fixed", "constrained-str", "float"}
    position = item["loc"].index(part)
    return isinstance(part, str) and (part in tags or "[" in part) and position > 1


def _tag(item: Any) -> str:
    return str(item["ctx"]["discriminator"]).strip("'")


def _tags(item: Any) -> str:
    tags = item["ctx"].get("expected_tags")
    return str(tags).replace("'", '"') if tags else "the known kinds"


def _short(value: Any) -> str:
    text = f'"{value}"' if isinstance(value, str) else repr(value)
    return text if len(text) < 60 else text[:57] + "..."


def _siblings(model: Any, path: tuple[Any, ...]) -> list[str]:
    """Return the keys that are known at `path` of a pydantic model."""
    found: set[str] = set()
    _collect(model, list(path), found)
    return sorted(found)


def _collect(kind: Any, path: list[Any], found: set[str]) -> None:
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        if not path:
            found.update(kind.model_fields)
        elif path[0] in kind.model_fields:
            _collect(kind.model_fields[path[0]].annotation, path[1:], found)
        elif path[0] == kind.__name__ or path[0] in _literal_tags(kind):
            _collect(kind, path[1:], found)
        return
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is dict:
        _collect(arguments[1], path[1:], found)
    elif origin is list:
        _collect(arguments[0], path[1:] if path and isinstance(path[0], int) else path, found)
    else:
        members = [a for a in arguments if isinstance(a, type) or get_origin(a) is not None]
        tagged = [a for a in members if path and path[0] in _literal_tags(a)]
        for member in tagged or members:
            _collect(member, path, found)


def _literal_tags(kind: Any) -> set[Any]:
    if not (isinstance(kind, type) and issubclass(kind, BaseModel)):
        return set()
    tags: set[Any] = {kind.__name__}
    for name in ("kind", "shape"):
        if name in kind.model_fields:
            tags.update(get_args(kind.model_fields[name].annotation))
    return tags
