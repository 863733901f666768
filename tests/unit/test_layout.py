"""The order of the constraint rows: narrow profiles, so that cost grows with bodies, not faster."""

import numpy as np
import pytest
from samples.mechanism_samples import bricard, chain, four_bars

from plymotion.solver.dynamics.model.layout import Layout, make_layout


def _hinged(pairs: list[tuple[int, int]], seed: int | None = None) -> Layout:
    """Bodies joined in pairs by five rows each, -1 being the ground; a seed mixes numbers."""
    pairs = np.array(pairs)
    nb = int(pairs.max()) + 1
    if seed is not None:
        rng = np.random.default_rng(seed)
        pairs = rng.permutation(np.append(rng.permutation(nb), -1)[pairs])
    return make_layout(
        np.zeros(nb, dtype=np.int64),
        pairs.ravel(),
        np.arange(pairs.size).reshape(-1, 2),
        5 * np.arange(len(pairs) + 1),
        np.zeros((0, 2), dtype=np.int64),
    )


def _chain(n):
    return [(k - 1, k) for k in range(n)]


def _tree(n):
    return [((k + 1) // 2 - 1, k) for k in range(n)]


def _caterpillar(n):
    """A chain of every other body, with one more hanging on each."""
    return [(k - 2 + k % 2 if k else -1, k) for k in range(n)]


def _multiplications(layout: Layout) -> int:
    """What elimination in the profile takes, counted as it runs."""
    first, n = layout.mass.first, layout.mass.place.size
    return sum(j - max(first[i], first[j]) + 1 for i in range(n) for j in range(first[i], i))


@pytest.mark.parametrize("seed", [None, 1])
@pytest.mark.parametrize("shape", [_chain, _caterpillar])
def test_cost_of_chains_is_linear(shape, seed):
    """Whatever the numbers of bodies and joints: each body more costs the same again."""
    sizes = [8, 16, 32, 64]
    entries = [int(_hinged(shape(n), seed).mass.profile_start[-1]) for n in sizes]
    costs = [_multiplications(_hinged(shape(n), seed)) for n in sizes]
    for found in (entries, costs):
        per_body = np.diff(found) / np.diff(sizes)
        np.testing.assert_allclose(per_body, per_body[0], rtol=0.02)
    assert max(entries) / sizes[-1] <= 5 * 11


def test_a_ring_costs_a_few_times_a_chain():
    for n in (16, 64):
        ring = _multiplications(_hinged([*_chain(n), (n - 1, -1)], seed=2))
        closed = _multiplications(_hinged([(k, (k + 1) % n) for k in range(n)], seed=2))
        chain_of_n = _multiplications(_hinged(_chain(n)))
        assert ring <= 1.2 * chain_of_n  # the ground couples nothing
        assert closed <= 6.0 * chain_of_n


@pytest.mark.parametrize("seed", [None, 1])
def test_trees_stay_far_from_square_growth(seed):
    """n bodies, each with two more on it: entries as n log n, multiplications as n log^2 n."""
    sizes = np.array([63, 127, 255, 511])
    layouts = [_hinged(_tree(n), seed) for n in sizes]
    entries = np.array([layout.mass.profile_start[-1] for layout in layouts])
    costs = np.array([_multiplications(layout) for layout in layouts])
    levels = np.log2(sizes + 1)
    more = np.diff(entries / sizes)  # each level more, the same again for each body
    np.testing.assert_allclose(more, more[-1], rtol=0.1)
    assert more[-1] < 25
    # of a square growth sixteen bodies for one would cost sixteen times as much a body
    each = costs / (sizes * levels**2)
    np.testing.assert_allclose(each, each[-1], rtol=0.25)


@pytest.mark.parametrize("seed", range(5))
def test_every_row_has_one_place_and_the_profile_holds_every_pair(seed):
    """Bodies at random, with loops: two rows at one body meet within the profile."""
    rng = np.random.default_rng(seed)
    n = 12
    pairs = [(int(rng.integers(-1, k)), k) for k in range(n)]
    pairs += [tuple(rng.choice(n, 2, replace=False)) for _ in range(4)]
    layout = _hinged(pairs, seed)
    order = layout.mass
    n_c = order.place.size
    assert sorted(order.place) == list(range(n_c))
    assert (order.first <= np.arange(n_c)).all()
    np.testing.assert_array_equal(np.diff(order.profile_start), np.arange(n_c) - order.first + 1)
    for body in range(n):
        rows = order.place[layout.body_row[layout.row_start[body] : layout.row_start[body + 1]]]
        assert (order.first[rows] <= rows.min()).all()
    assert layout.body_row.size == 2 * n_c - 5 * sum(-1 in pair for pair in pairs)
    assert order.most_rows == np.diff(layout.row_start).max()


@pytest.mark.parametrize("sample", [lambda: chain(5), lambda: four_bars(3), bricard])
def test_sides_of_joints_point_to_their_rows(sample):
    model = sample().model
    layout = model.layout
    for k in range(model.joint_kind.size):
        rows = np.arange(model.joint_row[k], model.joint_row[k + 1])
        for side in range(2):
            body = model.marker_body[model.joint_marker[k, side]]
            first = layout.side_row[k, side]
            assert (first < 0) == (body < 0)
            if body >= 0:
                begin = layout.row_start[body] + first
                np.testing.assert_array_equal(layout.body_row[begin : begin + rows.size], rows)


def test_bodies_without_constraints_and_constraints_without_bodies():
    none = np.zeros((0, 2), dtype=np.int64)
    free = make_layout(np.array([3, 0]), np.array([0]), none, np.zeros(1, np.int64), none)
    assert (free.mass.place.size, free.mass.profile_start.tolist(), free.widest) == (0, [0], 9)
    assert free.marker_used.size == 0
    grounded = _hinged([(-1, -1), (-1, 0)])
    assert sorted(grounded.mass.place) == list(range(10))
