"""Which layer reads which, and in which order they are evaluated."""

import itertools

import numpy as np
import pytest
from mesh_map.costs.layer_graph import LayerGraph
from toy_layers import TYPES, entry, evaluations, grid_map
from toy_layers import toys  # noqa: F401


def graph_of(*described):
    """Of (name, inputs): None is a layer that reads none, "all" one without inputs."""
    layers = {}
    for name, inputs in described:
        kind = "data" if inputs is None else "sum"
        params = {} if inputs in (None, "all") else {"inputs": inputs}
        layers[name] = TYPES[kind](name, params)
    return LayerGraph(layers)


def test_layers_without_inputs_read_those_before():
    graph = graph_of(("a", None), ("b", "all"), ("c", None), ("d", "all"))
    assert graph.order == ["a", "b", "c", "d"] and not graph.errors
    assert graph.inputs == {"a": (), "b": ("a",), "c": (), "d": ("a", "b", "c")}


def test_inputs_may_be_later_in_the_list():
    graph = graph_of(("final", ["y", "x"]), ("a", None), ("y", ["z"]), ("x", ["a"]), ("z", None))
    assert graph.order == ["a", "x", "z", "y", "final"]
    assert graph.inputs["final"] == ("y", "x") and graph.inputs["y"] == ("z",)


def test_what_is_free_is_in_the_order_of_the_list():
    names = ["c", "a", "d", "b"]
    assert graph_of(*((name, None) for name in names)).order == names
    assert graph_of(*((name, []) for name in names)).order == names


@pytest.mark.parametrize(
    "described, left, errors",
    [
        ([("a", ["a"])], [], {"a": "a reads a"}),
        (
            [("a", ["b"]), ("b", ["a"]), ("c", None)],
            ["c"],
            {"a": "a reads b, b reads a", "b": "a reads b, b reads a"},
        ),
        (
            [("n", None), ("a", ["n", "c"]), ("b", ["a"]), ("c", ["b"]), ("r", ["c"])],
            ["n", "r"],
            dict.fromkeys("abc", "a reads c, c reads b, b reads a"),
        ),
        ([("a", ["b"]), ("b", "all")], [], dict.fromkeys("ab", "a reads b, b reads a")),
        (
            [("a", ["b"]), ("b", ["a"]), ("c", ["d"]), ("d", ["c"]), ("e", "all")],
            ["e"],
            dict(
                dict.fromkeys("ab", "a reads b, b reads a"),
                **dict.fromkeys("cd", "c reads d, d reads c"),
            ),
        ),
    ],
)
def test_circles_are_named_and_left_out(described, left, errors):
    graph = graph_of(*described)
    assert graph.errors == {name: "cyclic inputs: " + text for name, text in errors.items()}
    assert graph.order == left and set(graph.inputs) == set(left)


def test_inputs_that_do_not_exist_or_are_left_out():
    layers = {"a": TYPES["sum"]("a", {"inputs": ["b", "x", "y"]})}
    assert LayerGraph(layers).errors == {"a": "its input b is no layer (known: none)"}
    assert LayerGraph(layers, {"b": "", "x": ""}).errors["a"].startswith("its input y")
    graph = LayerGraph(layers, ("b", "x", "y"))
    assert graph.order == ["a"] and graph.inputs["a"] == ("b", "x", "y")
    broken = graph_of(("a", ["b", "x"]), ("b", ["a"]))
    assert list(broken.errors) == ["a"] and broken.order == ["b"]  # whose input is left out


def test_all_small_graphs():
    """Left out is exactly what reads itself; all others are in the one order that there is."""
    names = "abcd"
    pairs = [(one, other) for one in names for other in names if one < other]
    for choice in itertools.product(range(4), repeat=len(pairs)):
        reads = {name: [] for name in names}
        for (one, other), kind in zip(pairs, choice):
            if kind & 1:
                reads[one].append(other)
            if kind & 2:
                reads[other].append(one)
        matrix = np.array([[other in reads[one] for other in names] for one in names])
        reach = matrix.copy()
        for _ in names:
            reach = reach | (reach @ reach)
        graph = graph_of(*reads.items())
        alone = [name for place, name in enumerate(names) if not reach[place, place]]
        assert set(graph.errors) == set(names) - set(alone)
        waiting, order = list(alone), []
        while waiting:
            chosen = next(n for n in waiting if not set(reads[n]) & set(waiting))
            waiting.remove(chosen)
            order.append(chosen)
        assert graph.order == order


def test_bad_inputs_do_not_harm_the_others(toys, caplog):  # noqa: F811
    mesh_map = grid_map()
    mesh_map.compute_layers(
        [
            entry("ground", "data"),
            entry("broken", "data", fails=True),
            entry("one", "sum", ["two"]),
            entry("two", "sum", ["one"]),
            entry("lost", "sum", ["fire", "ground"]),
            entry("after", "sum", ["ground", "broken"]),
            entry("behind", "sum", ["after"]),
            entry("wrong", "sum", "ground"),
            entry("good", "sum", ["ground"]),
            entry("all", "sum"),
        ]
    )
    assert list(mesh_map.layers) == ["ground", "good", "all"]
    circle = "cyclic inputs: one reads two, two reads one"
    assert mesh_map.layer_errors == {
        "broken": "RuntimeError: it was told to fail",
        "one": circle,
        "two": circle,
        "lost": "its input fire is no layer "
        "(known: ground, broken, one, two, after, behind, good, all)",
        "after": "its input broken is left out",
        "behind": "its input after is left out",
        "wrong": "inputs is 'ground', but it has to be a list of names of layers",
    }
    assert caplog.messages.count("layer one, two is left out: " + circle) == 1
    assert len(caplog.messages) == 6
    evaluations()
    mesh_map.set_layer_parameters("ground", {"scale": 2.0})
    assert evaluations() == {"ground": 1}  # all of 0 times 2 is as before
