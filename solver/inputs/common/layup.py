"""Lay-ups as text in the notation of the field: [0/45/-45/90]s, [±45/0_2]2s, [(0/90)_3/45]T."""

import re

MOST_PLIES, MOST_CHARACTERS = 10_000, 500  # more than any laminate has
_PLY = re.compile(r"(?P<pair>±|∓|\+/-|\+-|-\+)?(?P<angle>[+-]?\d+(?:\.\d*)?)°?")
_TIMES = re.compile(r"(?:_?\{?(\d+)\}?)?([sStT]?)")  # after a bracket; after a ply with _ only
_SUBSCRIPTS = re.compile("[₀-₉]+")


def angles_of(text: str) -> list[float]:
    """Return the angle of each ply of a lay-up in order [deg].

    Plies are separated by / or a comma; ±45 is 45/-45. A ply or group in brackets may have a number
    of repetitions, 0_2 or (0/90)_3, also as a subscript. After a bracket, s mirrors the group and T
    (total) does not: [0/90]2s is 0/90/0/90/90/0/90/0.

    Raises
    ------
    ValueError : the part that cannot be read.
    """
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f"expected {MOST_CHARACTERS} characters at most")
    digits = _SUBSCRIPTS.sub(lambda m: "_" + "".join(str(ord(c) - ord("₀")) for c in m[0]), text)
    spaced = digits.replace("ₛ", "s").replace("ₜ", "T")
    plain = re.sub(r"_(?=[sStT])", "", re.sub(r"\s*([^\d.])\s*", r"\1", spaced))
    if not plain.startswith("["):
        raise ValueError("expected brackets, such as [0/45/-45/90]s")
    angles, end = _group(plain, 1)
    if plain[end:]:
        raise ValueError(f'expected a number, s or T after the last bracket, found "{plain[end:]}"')
    return angles


def _group(text: str, place: int) -> tuple[list[float], int]:
    """Return the angles of a group from behind its bracket on, and where it ends."""
    close = {"(": ")", "[": "]"}[text[place - 1]]
    angles: list[float] = []
    while True:
        ply = _PLY.match(text, place)
        if text[place : place + 1] in ("(", "["):
            inner, place = _group(text, place + 1)
            angles += inner
        elif ply is None:
            raise ValueError(f'expected an angle, found "{text[place:]}"')
        else:
            angle, place = float(ply["angle"]) + 0.0, ply.end()
            if abs(angle) > 90.0:
                raise ValueError(f"{angle:g}: expected an angle from -90 to 90 deg")
            one = [-angle, angle] if ply["pair"] in ("∓", "-+") else [angle, -angle]
            times = _TIMES.match(text, place) if text[place : place + 1] == "_" else None
            place = times.end() if times else place
            angles += _repeated(one if ply["pair"] else [angle], times and times[1])
        mark, place = text[place : place + 1], place + 1
        if mark == close:
            break
        if mark not in ("/", ","):
            raise ValueError(f'expected / or {close}, found "{text[place - 1 :]}"')
    end = _TIMES.match(text, place)
    assert end is not None
    angles = _repeated(angles, end[1])
    return (angles + angles[::-1] if end[2] in ("s", "S") else angles), end.end()


def _repeated(angles: list[float], times: str | None) -> list[float]:
    count = int(times or 1)
    if not 0 < count * len(angles) <= MOST_PLIES:
        raise ValueError(f"{count} times {len(angles)} plies: expected up to {MOST_PLIES}")
    return angles * count
