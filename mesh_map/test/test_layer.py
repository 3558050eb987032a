"""Parameters, the contract of a layer, and the combination of layers."""

import math

import numpy as np
import pytest
from mesh_map.combination import combine
from mesh_map.errors import MeshMapError
from mesh_map.layer import Layer, LayerResult, checked_result
from mesh_map.layers.height_diff import HeightDiffLayer
from mesh_map.parameter import Parameter

INF, NAN = math.inf, math.nan


def test_declared_parameters_of_height_diff():
    declared = {p.name: (p.default, p.minimum, p.maximum) for p in HeightDiffLayer.all_parameters()}
    assert declared == {
        "threshold": (0.185, 0.05, 1.0),
        "radius": (0.3, 0.02, 1.0),
        "factor": (1.0, 0.0, 1.0),
    }
    layer = HeightDiffLayer("height_diff")
    assert layer.params == {"threshold": 0.185, "radius": 0.3, "factor": 1.0}
    assert not layer.warnings and layer.result is None


def test_values_out_of_range_are_limited_with_a_warning():
    """As dynamic_reconfigure does; a configuration in the field has a radius of 0."""
    layer = HeightDiffLayer("h", {"radius": 0.0, "threshold": INF, "factor": 0.7})
    assert layer.params == {"radius": 0.02, "threshold": 1.0, "factor": 0.7}
    assert layer.warnings == [
        "threshold is inf, outside of [0.05, 1.0]: 1.0 is used",
        "radius is 0.0, outside of [0.02, 1.0]: 0.02 is used",
    ]


def test_whole_numbers_are_numbers():
    layer = HeightDiffLayer("h", {"factor": 1})
    assert layer.params["factor"] == 1.0 and isinstance(layer.params["factor"], float)


def test_unknown_parameters_are_named():
    layer = HeightDiffLayer("h", {"treshold": 0.2})
    assert layer.warnings == ["unknown parameters: treshold (known: factor, radius, threshold)"]


@pytest.mark.parametrize("value", [NAN, "0.3", True, None, [0.3]])
def test_values_that_are_no_numbers_are_refused(value):
    with pytest.raises(MeshMapError, match="^radius is .*, but it has to be a number$"):
        HeightDiffLayer("h", {"radius": value})


def test_parameters_of_other_types():
    assert Parameter("count", 3, 0, 10).checked(7.0) == (7, "")
    assert Parameter("on", True).checked(False) == (False, "")
    assert Parameter("topic", "cloud").checked("scan") == ("scan", "")
    assert Parameter("count", 3, 0, 10).checked(11)[0] == 10
    for parameter, value, message in (
        (Parameter("count", 3), 7.5, "count is 7.5, but it has to be a whole number"),
        (Parameter("count", 3), INF, "count is inf, but it has to be a finite number"),
        (Parameter("on", True), 1, "on is 1, but it has to be a boolean"),
        (Parameter("topic", "cloud"), 1, "topic is 1, but it has to be a string"),
    ):
        with pytest.raises(MeshMapError, match=message):
            parameter.checked(value)


def test_stored_parameters_are_those_that_costs_depend_on():
    layer = HeightDiffLayer("h", {"radius": 0.5, "threshold": 0.4}, "mesh_layers/HeightDiffLayer")
    assert layer.stored_parameters() == {"radius": 0.5, "type": "mesh_layers/HeightDiffLayer"}
    costs = np.array([0.3, 0.5, NAN, INF], np.float32)
    assert layer.reuse(costs).lethal.tolist() == [False, True, False, True]


def test_results_are_checked():
    costs = np.array([0, 1, INF, NAN])
    result = checked_result(costs, [1], 4)
    assert result.costs.dtype == np.float32 and np.array_equal(result.costs, costs, equal_nan=True)
    assert result.lethal.tolist() == [False, True, True, False]
    assert checked_result([1e60, 0, 0, 0], [], 4).lethal.tolist() == [True, False, False, False]
    mask = np.array([True, False, False, False])
    assert checked_result(costs, mask, 4).lethal.tolist() == [True, False, True, False]
    assert mask.tolist() == [True, False, False, False]
    for bad_costs, bad_lethal, message in (
        (costs[:3], [], r"the costs are of shape \(3,\) and type float64, but 4 numbers"),
        (costs[:, None], [], r"the costs are of shape \(4, 1\)"),
        (["a"] * 4, [], "the costs are of shape"),
        (costs, [4], "a lethal vertex does not exist: there are 4"),
        (costs, [-1], "a lethal vertex does not exist"),
        (costs, mask[:3], "the lethal vertices have to be 4 booleans or indices"),
        (costs, [0.5], "the lethal vertices have to be"),
        ([0, -1, -2, 0], [], r"the cost of vertex 1 is -1 \(2 negative ones in all\)"),
        ([0, 0, 0, -INF], [3], r"the cost of vertex 3 is -inf \(1 negative"),
    ):
        with pytest.raises(MeshMapError, match=message):
            checked_result(bad_costs, bad_lethal, 4)


def test_a_layer_needs_compute():
    with pytest.raises(TypeError):
        Layer("nothing")


def result_of(costs, lethal=()):
    return checked_result(np.array(costs, np.float32), np.array(lethal, np.int64), len(costs))


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
