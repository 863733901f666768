"""Plies and lamination parameters against published best lay-ups of thin plates."""

import itertools

import pytest
from samples.thin_plates import BEST, PLY, STEPS, Square, bending, load_factors, parameters


@pytest.mark.parametrize("name", sorted(BEST["buckling"]))
def test_load_factors(name: str) -> None:
    table = BEST["buckling"][name]
    D = bending("riche", 2.0 * PLY * len(table["plies"]), parameters(table["plies"]))
    found = load_factors(D, table["length"], table["width"], table["ratio"]).min()
    assert found == pytest.approx(table["value"], rel=BEST["tolerance"])


@pytest.mark.parametrize(("edges", "held"), [("supported", 1), ("clamped", 2)])
def test_frequencies(edges: str, held: int) -> None:
    """The lay-up is the best of all 256, but for its mirror image in the diagonal or in an edge."""
    table, some = BEST["frequency"][edges], Square(held, 6)
    assert Square(held, 12).frequency(table["plies"]) == pytest.approx(table["value"], abs=5e-3)
    tried = {a: some.frequency(a) for a in itertools.product(STEPS, repeat=4)}
    first, second, third = sorted(tried, key=lambda a: -tried[a])[:3]
    assert tuple(table["plies"]) in (first, second)
    assert tried[first] == pytest.approx(tried[second], rel=1e-9)
    assert tried[third] < tried[second] * (1.0 - 1e-6)
