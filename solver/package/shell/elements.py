"""Elements that a shell description may name, with their meaning in half a line.

The formulas are in preprocess/shell, a file each, which the solver does not import: this list is
what both halves know. The preprocessor refuses to start when its files and this list differ.
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
DRILLINGS = {
    "fictitious": "the paper's fictitious one",
    "tie": "a tie to the rotation of the membrane",
}

# What a description that does not say gets.
PLATE, MEMBRANE, DRILLING = "dkmt", "opt", "auto"
BETA0, DRILLING_FACTOR = 0.5, 1e-2


def in_words(meanings: dict[str, str]) -> str:
    """Return names and meanings as a list in words; those that mean the same stand together."""
    names: dict[str, list[str]] = {}
    for name, meaning in meanings.items():
        names.setdefault(meaning, []).append(name)
    return ", ".join(f"{' and '.join(same)} {meaning}" for meaning, same in names.items())
