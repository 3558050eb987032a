"""Layers that combine others: sum, mean and maximum."""

import math

import numpy as np
import pytest
from mesh_map.base.plugins import find_class
from mesh_map.costs.layer import BASE_CLASS_TYPE, LayerInput, checked
from mesh_map.layers.combination_layer import (
    MaxCombinationLayer,
    SumCombinationLayer,
    WeightedCombinationLayer,
)
from toy_layers import grid_map

INF, NAN = math.inf, math.nan
CLASSES = (SumCombinationLayer, WeightedCombinationLayer, MaxCombinationLayer)


def read(costs, lethal=(), weight=1.0):
    result = checked((np.array(costs, np.float32), np.array(lethal, np.int64)), len(costs))
    return LayerInput(*result, weight)


def evaluated(kind, *inputs):
    count = len(inputs[0].costs) if inputs else 3
    names = {"layer_%d" % number: one for number, one in enumerate(inputs)}

    class Map:
        vertices = np.zeros((count, 3))

    return kind("combined").evaluate(Map, names)


def test_names_of_ros_2():
    for name, kind in (
        ("SumCombinationLayer", SumCombinationLayer),
        ("AvgCombinationLayer", SumCombinationLayer),
        ("MaxCombinationLayer", MaxCombinationLayer),
        ("WeightedCombinationLayer", WeightedCombinationLayer),
    ):
        assert find_class("mesh_map", BASE_CLASS_TYPE, "mesh_layers/" + name) is kind


def test_sum_mean_and_maximum():
    inputs = read([1, 0, 4], weight=0.5), read([2, 0, 1], weight=0.25), read([8, 0, 0], weight=0)
    assert evaluated(SumCombinationLayer, *inputs).costs.tolist() == [1.0, 0, 2.25]
    mean = np.array([1.0, 0, 2.25]) / 0.75
    assert evaluated(WeightedCombinationLayer, *inputs).costs.tolist() == (
        mean.astype(np.float32).tolist()
    )
    assert evaluated(MaxCombinationLayer, *inputs).costs.tolist() == [8, 0, 4]
    unweighted = evaluated(WeightedCombinationLayer, read([1, 2], weight=0), read([1, 2], weight=0))
    assert unweighted.costs.tolist() == [0, 0]


@pytest.mark.parametrize("kind", CLASSES)
def test_lethal_is_infinite_and_unknown_stays_unknown(kind):
    inputs = read([1, INF, NAN, NAN, 2], [0], 0.5), read([1, 0, INF, 1, 2], (), 0.0)
    result = evaluated(kind, *inputs)
    assert result.lethal.tolist() == [True, True, True, False, False]
    assert np.isposinf(result.costs).tolist() == result.lethal.tolist()
    assert math.isnan(result.costs[3]) and result.costs[4] in (1, 2)


@pytest.mark.parametrize("kind", CLASSES)
def test_without_inputs_everything_is_free(kind):
    result = evaluated(kind)
    assert result.costs.tolist() == [0, 0, 0] and not result.lethal.any()


def test_sums_that_are_too_large_are_lethal():
    result = evaluated(SumCombinationLayer, read([3e38, 1]), read([3e38, 1]))
    assert result.costs.tolist() == [INF, 2] and result.lethal.tolist() == [True, False]


@pytest.mark.parametrize("kind", CLASSES)
def test_an_update_is_as_the_whole(kind):
    random = np.random.default_rng(5)
    mesh_map = grid_map(40)
    count = len(mesh_map.vertices)
    layer = kind("combined")
    costs = random.uniform(0, 2, (3, count)).astype(np.float32)
    lethal = random.uniform(size=(3, count)) < 0.1

    def inputs():
        return {
            str(number): LayerInput(costs[number].copy(), lethal[number].copy(), None, 0.3 * number)
            for number in range(3)
        }

    before = layer.evaluate(mesh_map, inputs())
    for share in (0, 0.001, 0.1, 0.5, 1):
        changed = np.flatnonzero(random.uniform(size=count) < share).astype(np.uint32)
        number = random.integers(3)
        costs[number, changed] = random.uniform(0, 2, len(changed))
        costs[number, changed[::5]] = np.nan
        lethal[number, changed] = random.uniform(size=len(changed)) < 0.5
        found = checked(layer.update(mesh_map, inputs(), changed, before), count)
        whole = layer.evaluate(mesh_map, inputs())
        assert np.array_equal(found.costs.view(np.uint32), whole.costs.view(np.uint32))
        assert np.array_equal(found.lethal, whole.lethal)
        before = found


@pytest.mark.parametrize("kind", CLASSES)
def test_stored_costs_are_used_again(kind):
    whole = evaluated(kind, read([1, INF, NAN], [0]), read([1, 2, 3]))
    again = checked(kind("combined").reuse(whole.costs, None, {}), 3)
    assert np.array_equal(again.costs, whole.costs, equal_nan=True)
    assert np.array_equal(again.lethal, whole.lethal)
