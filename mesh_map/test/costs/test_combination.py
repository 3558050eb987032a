"""All layers in one: modes of the combination, and that of a part."""

import math

import numpy as np
import pytest
from mesh_map.costs.combination import Combination
from mesh_map.costs.layer import LayerResult, checked

INF, NAN = math.inf, math.nan
MODES = ("sum", "normalized", "max")


def result_of(costs, lethal=()):
    return checked((np.array(costs, np.float32), np.array(lethal, np.int64)), len(costs))


def combine(results, vertex_count, mode="sum"):
    return Combination(results, vertex_count, mode).costs


def test_combination_is_the_released_sum():
    first = result_of([0, 1, 2, 3], lethal=[3])
    second = result_of([10, 20, NAN, NAN])
    combined = combine([(first, 1.0), (second, 0.5)], 4)
    assert combined.dtype == np.float32
    assert np.array_equal(combined, [5, 11, NAN, INF], equal_nan=True)


def test_lethal_stays_lethal_whatever_the_factor():
    combined = combine([(result_of([INF, 1, 2], lethal=[1]), 0.0)], 3)
    assert combined.tolist() == [INF, INF, 0]
    unknown = combine([(result_of([NAN, 0, 0]), 0.0)], 3)
    assert np.array_equal(unknown, [NAN, 0, 0], equal_nan=True)


def test_combination_of_nothing_is_free():
    assert combine([], 3).tolist() == [0, 0, 0]


def test_combination_equals_numpy():
    random = np.random.default_rng(0)
    results, total = [], np.zeros(1000)
    for factor in (0.3, 1.0, 0.0, 0.7):
        costs = random.uniform(0, 2, 1000).astype(np.float32)
        results.append((LayerResult(costs, costs > 1.9), factor))
        total += np.where(costs > np.float32(1.9), np.inf, factor * costs.astype(np.float64))
    assert np.array_equal(combine(results, 1000), total.astype(np.float32))
    assert 0 < np.isinf(total).sum() < 1000


def oracle(results, mode):
    """The modes as they are written down, one vertex after the other."""
    count = len(results[0][0].costs)
    limits = []
    for result, _ in results:
        finite = [float(cost) for cost in result.costs if math.isfinite(cost)]
        limits.append((min(finite), max(finite)) if finite else (0.0, 0.0))
    combined = np.zeros(count, np.float32)
    for vertex in range(count):
        terms = []
        for (result, factor), (low, high) in zip(results, limits):
            cost = float(result.costs[vertex])
            if mode == "normalized":
                cost = factor * (cost - low) / (high - low) if high > low else 0 * cost
            else:
                cost = factor * cost
            terms.append(cost)
        if any(result.lethal[vertex] for result, _ in results):
            combined[vertex] = np.inf
        elif any(math.isnan(term) for term in terms):
            combined[vertex] = np.nan
        else:
            combined[vertex] = max(terms + [0.0]) if mode == "max" else sum(terms)
    return combined


def random_results(random, count, layers):
    results = []
    for _ in range(layers):
        costs = random.uniform(0, 3, count).astype(np.float32)
        costs[random.uniform(size=count) < 0.05] = np.nan
        costs[random.uniform(size=count) < 0.05] = np.inf
        lethal = random.uniform(size=count) < 0.1
        results.append((checked((costs, lethal), count), float(random.uniform())))
    return results


@pytest.mark.parametrize("mode", MODES)
def test_each_mode_equals_its_formula(mode):
    random = np.random.default_rng(1)
    for layers in (1, 2, 5):
        results = random_results(random, 500, layers)
        results.append((result_of(np.full(500, 0.7)), 1.0))  # all costs equal: 0 when normalized
        combined = combine(results, 500, mode)
        assert combined.dtype == np.float32 and not combined.flags.writeable
        assert np.array_equal(combined, oracle(results, mode), equal_nan=True)
        assert {np.isnan(combined).any(), np.isinf(combined).any()} == {True}


def test_normalized_costs_are_from_0_to_1():
    first, second = result_of([2, 4, 3, INF]), result_of([INF, 100, 300, 200])
    combined = combine([(first, 1.0), (second, 0.5)], 4, "normalized")
    assert combined.tolist() == [INF, 1.0, 1.0, INF]
    assert combine([(result_of([INF, NAN]), 1.0)], 2, "normalized")[0] == INF
    assert math.isnan(combine([(result_of([INF, NAN]), 1.0)], 2, "normalized")[1])


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("share", [0, 0.01, 0.2, 0.6])
def test_a_part_is_as_the_whole(mode, share):
    """Only what has changed is computed, with the result of all, bit for bit."""
    random = np.random.default_rng(2)
    count = 3000
    results = random_results(random, count, 4)
    before = Combination(results, count, mode)
    for step in range(12):
        number = int(random.integers(4))
        result, factor = results[number]
        changed = np.flatnonzero(random.uniform(size=count) < share)
        costs, lethal = result.costs.copy(), result.lethal & ~np.isinf(result.costs)
        # Every other time also the limits of the costs, which change all that is normalized.
        costs[changed] = random.uniform(0.5, 2.5 + 3 * (step % 2), len(changed))
        lethal[changed] = random.uniform(size=len(changed)) < 0.3
        costs[changed[::7]] = np.nan
        results[number] = (checked((costs, lethal), count), factor)
        after = Combination(results, count, mode, before, changed)
        whole = combine(results, count, mode)
        assert np.array_equal(after.costs.view(np.uint32), whole.view(np.uint32))
        before = after


@pytest.mark.parametrize("mode", MODES)
def test_a_part_is_not_enough_where_all_is_another(mode):
    random = np.random.default_rng(3)
    results = random_results(random, 100, 3)
    before = Combination(results, 100, mode)
    nothing = np.zeros(0, np.uint32)
    others = [
        [(results[0][0], 0.123)] + results[1:],
        results[:2],
        results + results[:1],
        results[::-1],
        [],
    ]
    for other in others:
        after = Combination(other, 100, mode, before, nothing).costs
        assert np.array_equal(after, combine(other, 100, mode), equal_nan=True)
    assert Combination(results, 100, mode, before, nothing).costs is before.costs
    for other in MODES:
        after = Combination(results, 100, other, before, nothing).costs
        assert np.array_equal(after, combine(results, 100, other), equal_nan=True)
