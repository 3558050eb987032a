"""Parameters, and the contract of a layer."""

import math

import numpy as np
import pytest
from mesh_map import MeshMap
from mesh_map.base.errors import MeshMapError
from mesh_map.base.parameter import Parameter
from mesh_map.costs.layer import Layer, LayerInput, checked
from mesh_map.layers.threshold_layer import HeightDiffLayer

INF, NAN = math.inf, math.nan


def test_declared_parameters_of_height_diff():
    declared = {p.name: (p.default, p.minimum, p.maximum) for p in HeightDiffLayer.all_parameters()}
    assert declared == {
        "threshold": (0.185, 0.05, 1.0),
        "radius": (0.3, 0.02, 1.0),
        "include_vertex": (True, None, None),
        "large_faces": (True, None, None),
        "factor": (1.0, 0.0, 1.0),
        "combination_weight": (1.0, 0.0, 1.0),
        "enabled": (True, None, None),
    }
    layer = HeightDiffLayer("height_diff")
    assert layer.params == {name: default for name, (default, _, _) in declared.items()}
    assert not layer.warnings and layer.result is None


def test_values_out_of_range_are_limited_with_a_warning():
    """As dynamic_reconfigure does; a configuration in the field has a radius of 0."""
    layer = HeightDiffLayer("h", {"radius": 0.0, "threshold": INF, "factor": 0.7})
    limited = {"radius": 0.02, "threshold": 1.0, "factor": 0.7}
    assert layer.params == {**HeightDiffLayer("h").params, **limited}
    assert layer.warnings == [
        "threshold is inf, outside of [0.05, 1.0]: 1.0 is used",
        "radius is 0.0, outside of [0.02, 1.0]: 0.02 is used",
        "radius, 0.02 m, is not above threshold, 1.0 m: an upright step may not be seen",
    ]


def test_whole_numbers_are_numbers():
    layer = HeightDiffLayer("h", {"factor": 1})
    assert layer.params["factor"] == 1.0 and isinstance(layer.params["factor"], float)


def test_numbers_of_numpy_are_numbers():
    for value in (np.float32(0.5), np.float64(0.5)):
        found, warning = Parameter("radius", 0.3, 0.0, 1.0).checked(value)
        assert (found, type(found), warning) == (0.5, float, "")
    for value in (np.int64(5), np.uint8(5), np.float32(5)):
        found, warning = Parameter("count", 3, 0, 10).checked(value)
        assert (found, type(found), warning) == (5, int, "")
    assert Parameter("on", False).checked(np.bool_(True)) == (True, "")
    for value in (np.float32("nan"), np.bool_(True), np.array(0.5), 1j):
        with pytest.raises(MeshMapError, match="^radius is .*, but it has to be a number$"):
            Parameter("radius", 0.3, 0.0, 1.0).checked(value)


@pytest.mark.parametrize("default", [3, 3.0])
def test_numbers_that_are_too_large(default):
    huge = 10**400
    for value in (huge, -huge):
        with pytest.raises(MeshMapError, match="count is -?1000.*, but .* a finite number"):
            Parameter("count", default).checked(value)
    assert Parameter("count", default, 0, 10).checked(huge)[0] == 10
    assert Parameter("count", default, 0, 10).checked(-huge)[0] == 0
    with pytest.raises(MeshMapError, match="count is inf, but it has to be a whole number"):
        Parameter("count", 3, 0, INF).checked(INF)


class ModestLayer(Layer):
    PARAMETERS = (Parameter("factor", 0.25, 0.0, 0.5, affects_costs=False),)

    def compute(self, mesh_map, inputs):
        return np.zeros(len(mesh_map.vertices)), []


def test_a_layer_may_have_a_factor_of_its_own():
    names = [p.name for p in ModestLayer.all_parameters()]
    assert names == ["factor", "combination_weight", "enabled"]
    assert ModestLayer("m").params == {"factor": 0.25, "combination_weight": 1.0, "enabled": True}
    layer = ModestLayer("m", {"factor": 0.125})
    assert layer.params["factor"] == 0.125 and not layer.warnings
    assert layer.checked_changes({"factor": 1.0})[0]["factor"] == 0.5


def test_unknown_parameters_are_named():
    layer = HeightDiffLayer("h", {"treshold": 0.2})
    assert layer.warnings == [
        "unknown parameters: treshold "
        "(known: combination_weight, enabled, factor, include_vertex, large_faces, radius, "
        "threshold)"
    ]


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


def test_limits_may_be_infinite():
    assert Parameter("height", INF, 0.0, INF).checked(INF) == (INF, "")
    assert Parameter("height", 1.0, 0.0, INF).checked(3) == (3.0, "")
    assert Parameter("value", 0.0, -INF, 5.0).checked(-INF) == (-INF, "")
    assert Parameter("value", 0.0, -INF, 5.0).checked(INF)[0] == 5.0
    for parameter, value in (
        (Parameter("height", 1.0), INF),
        (Parameter("height", 1.0, 0.0), INF),
        (Parameter("height", 1.0, maximum=5.0), -INF),
    ):
        with pytest.raises(MeshMapError, match="height is -?inf, but .* a finite number"):
            parameter.checked(value)


def test_choices_lists_and_dictionaries():
    fading = Parameter("fading", "cosine", choices=("cosine", "exponential"))
    assert fading.checked("exponential") == ("exponential", "")
    with pytest.raises(MeshMapError, match="fading is 'linear', .* one of cosine, exponential"):
        fading.checked("linear")
    axis = Parameter("axis", (0.0, 0.0, -1.0))
    assert axis.checked([1, 2]) == ((1, 2), "")
    costs = Parameter("costs", {})
    given = {"grass": 1.0}
    accepted, _ = costs.checked(given)
    given["grass"] = 2.0
    assert accepted == {"grass": 1.0}
    for parameter, value, message in ((axis, "abc", "a list"), (costs, [1], "a dictionary")):
        with pytest.raises(MeshMapError, match=message):
            parameter.checked(value)


def test_the_fingerprint_is_of_all_that_costs_depend_on():
    mesh_map = MeshMap([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    layer = HeightDiffLayer("h", {"radius": 0.5, "threshold": 0.4}, "mesh_layers/HeightDiffLayer")
    expected = {
        "radius": 0.5,
        "include_vertex": True,
        "large_faces": True,
        "type": "mesh_layers/HeightDiffLayer",
        "geometry": mesh_map.geometry.content_uuid,
    }
    assert layer.fingerprint(mesh_map, {}) == expected
    assert layer.identity == {}
    layer.evaluated(layer.evaluate(mesh_map, {}), mesh_map, {})
    assert layer.identity == expected
    costs = np.array([0.3, 0.5, NAN, INF], np.float32)
    assert layer.reuse(costs, mesh_map, {}).lethal.tolist() == [False, True, False, True]


class ReadingLayer(Layer):
    READS_LAYERS = True
    PARAMETERS = (Parameter("classes", ()), Parameter("speeds", {}))

    def compute(self, mesh_map, inputs):
        return np.zeros(len(mesh_map.vertices)), []


def test_the_fingerprint_of_a_layer_that_reads_layers():
    mesh_map = MeshMap([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    base = LayerInput(np.zeros(3, np.float32), np.zeros(3, np.bool_), None, 1.0)
    layer = ReadingLayer("r", {"classes": ["b", "a"], "speeds": {"y": 1, "x": 2}})
    found = layer.fingerprint(mesh_map, {"a": base})
    assert (found["classes"], found["speeds"]) == ('["b", "a"]', '{"x": 2, "y": 1}')
    others = [
        {"a": base._replace(costs=np.ones(3, np.float32))},
        {"a": base._replace(lethal=np.ones(3, np.bool_))},
        {"a": base._replace(vectors=np.zeros((3, 3), np.float32))},
        {"a": base._replace(weight=0.5)},
        {"b": base},
        {"a": base, "b": base},
        {},
    ]
    digests = [layer.fingerprint(mesh_map, inputs)["inputs"] for inputs in others]
    assert len(set(digests + [found["inputs"]])) == len(others) + 1
    assert layer.fingerprint(mesh_map, {"a": base}) == found
    layer.READS_WEIGHTS = False
    assert layer.fingerprint(mesh_map, others[3]) == layer.fingerprint(mesh_map, {"a": base})


@pytest.mark.parametrize(
    "inputs, message",
    [
        ("a", "inputs is 'a', but it has to be a list of names of layers"),
        ([1], "inputs is \\[1\\]"),
        (["a", "b", "a"], "inputs names a layer twice: a, b, a"),
    ],
)
def test_inputs_are_a_list_of_names(inputs, message):
    with pytest.raises(MeshMapError, match=message):
        ReadingLayer("r", {"inputs": inputs})


def test_inputs_of_layers():
    assert ReadingLayer("r").inputs is None
    assert ReadingLayer("r", {"inputs": []}).inputs == ()
    assert ReadingLayer("r", {"inputs": ["b", "a"]}).inputs == ("b", "a")
    other = HeightDiffLayer("h", {"inputs": ["b"]})
    assert other.inputs is None and other.warnings[0].startswith("unknown parameters: inputs")


def test_changes_of_parameters_are_checked_first():
    layer = HeightDiffLayer("h")
    before = dict(layer.params)
    params, warnings = layer.checked_changes({"radius": 7, "speed": 1})
    assert params == dict(before, radius=1.0) and layer.params == before
    assert [warning.split(",")[0] for warning in warnings] == [
        "radius is 7",
        "unknown parameters: speed (known: combination_weight",
    ]
    with pytest.raises(MeshMapError, match="radius is nan"):
        layer.checked_changes({"threshold": 0.3, "radius": NAN})
    with pytest.raises(MeshMapError, match="inputs cannot be changed"):
        ReadingLayer("r").checked_changes({"inputs": ["a"]})


def test_results_are_checked():
    costs = np.array([0, 1, INF, NAN])
    result = checked((costs, [1]), 4)
    assert result.costs.dtype == np.float32 and np.array_equal(result.costs, costs, equal_nan=True)
    assert result.lethal.tolist() == [False, True, True, False]
    assert checked(([1e60, 0, 0, 0], []), 4).lethal.tolist() == [True, False, False, False]
    mask = np.array([True, False, False, False])
    assert checked((costs, mask), 4).lethal.tolist() == [True, False, True, False]
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
            checked((bad_costs, bad_lethal), 4)


def test_vectors_are_checked():
    vectors = np.ones((2, 3))
    assert checked(([0, 0], []), 2).vectors is None
    assert checked(([0, 0], [], vectors), 2).vectors.dtype == np.float32
    for bad in (vectors[:1], vectors[:, :2], np.full((2, 3), NAN), np.full((2, 3), 1e300)):
        with pytest.raises(MeshMapError, match=r"the vectors have to be \(2, 3\) finite numbers"):
            checked(([0, 0], [], bad), 2)
    for bad in (None, ([0, 0],), ([0, 0], [], vectors, vectors)):
        with pytest.raises(MeshMapError, match="did not return costs and lethal vertices"):
            checked(bad, 2)
    assert checked(([0, 0], [], None), 2).vectors is None


def test_results_are_not_those_that_a_layer_writes_to_later():
    costs, vectors = np.zeros(2, np.float32), np.zeros((2, 3), np.float32)
    lethal = np.zeros(2, np.bool_)
    result = checked((costs, lethal, vectors), 2)
    costs[0], lethal[0], vectors[0] = 1, True, 1
    assert not result.costs.any() and not result.lethal.any() and not result.vectors.any()
    for array in result:
        with pytest.raises(ValueError):
            array[0] = 1
    again = checked(result, 2)
    assert np.shares_memory(again.costs, result.costs)
    assert np.shares_memory(again.vectors, result.vectors)


def test_a_layer_needs_compute():
    with pytest.raises(TypeError):
        Layer("nothing")
