"""Elements that a shell description may name, with a short description of each.

The formulas are in preprocess/shell, one file for each element. The solver does not import these
files, so both halves use this list. The preprocessor does not start if its files and this list
differ.
"""

PLATES = {
    "dkmt": "converges for laminates of any thickness",
    "dst": "is the paper's",
    "dkt": "has no shear",
    "mitc3": "is the simplest",
}
MEMBRANES = {
    "opt": "carry the rotation about the normal",
    "allman": "carry the rotation about the normal",
    "cst": "(the paper's) is too stiff in in-plane bending",
}
QUADS = {
    "dkmq": "converges for laminates of any thickness",
}
DRILLINGS = {
    "fictitious": "the paper's fictitious one",
    "tie": "a tie to the rotation of the membrane",
}

# Defaults of a description.
PLATE, MEMBRANE, DRILLING, QUAD = "dkmt", "opt", "auto", "dkmq"
BETA0, DRILLING_FACTOR = 0.5, 1e-2


def in_words(meanings: dict[str, str]) -> str:
    """Return names and descriptions as text; names with the same description are grouped."""
    names: dict[str, list[str]] = {}
    for name, meaning in meanings.items():
        names.setdefault(meaning, []).append(name)
    return ", ".join(f"{' and '.join(same)} {meaning}" for meaning, same in names.items())
