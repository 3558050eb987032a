"""Random layers that read each other, changed at random: as if computed anew, bit for bit."""

import numpy as np
import pytest
from mesh_map import MeshMap
from meshes import terrain
from toy_layers import calls, entry, evaluations, grid_map
from toy_layers import toys  # noqa: F401

READING = ("neighbors", "sum", "mean", "max")


def random_config(random, count):
    """Layers of data and those that read, in any order; some of inputs that come later."""
    names = ["layer_%d" % number for number in range(count)]
    rank = random.permutation(count)  # a layer reads those of lower rank: there are no circles
    config, last = [], 0
    for number, name in enumerate(names):
        lower = [other for other in range(count) if rank[other] < rank[number]]
        if not lower or random.uniform() < 0.35:
            config.append(entry(name, "data"))
            continue
        kind = READING[random.integers(4)]
        before_are_lower = all(rank[other] < rank[number] for other in range(number))
        if before_are_lower and number and random.uniform() < 0.5:
            config.append(entry(name, kind))
            last += 1
        else:
            chosen = random.choice(lower, random.integers(1, len(lower) + 1), replace=False)
            config.append(entry(name, kind, [names[other] for other in chosen]))
    return config


def inputs_of(mesh_map, name):
    """What a layer reads, by what it says."""
    layer = mesh_map.layers[name]
    if not layer.READS_LAYERS:
        return set()
    number = int(name.split("_")[1])
    before = {"layer_%d" % other for other in range(number)}
    return before if layer.inputs is None else set(layer.inputs)


def readers_of(mesh_map, name):
    """All that depend on a layer, directly or not."""
    found = {name}
    for other in mesh_map.layers:  # in the order of evaluation
        if found & inputs_of(mesh_map, other):
            found.add(other)
    return found - {name}


def assert_same(one, other):
    assert list(one.layers) == list(other.layers)
    for name in one.layers:
        for first, second in zip(one.layers[name].result, other.layers[name].result):
            assert (first is None) == (second is None)
            if first is not None:
                assert first.dtype == second.dtype
                assert first.tobytes() == second.tobytes(), name
    assert one.costs.tobytes() == other.costs.tobytes()
    first, second = one.planning_costs().edge_weights, other.planning_costs().edge_weights
    assert first.tobytes() == second.tobytes()


def random_change(random, mesh_map, data, params, settings):
    """One change; returns the name of the layer, and whether its own result may have changed."""
    count = len(mesh_map.vertices)
    name = list(mesh_map.layers)[random.integers(len(mesh_map.layers))]
    kind = random.integers(7)
    if kind == 6:
        enabled = not mesh_map.layers[name].params["enabled"]
        params.setdefault(name, {})["enabled"] = enabled
        mesh_map.set_layer_parameters(name, {"enabled": enabled})
        return name, "toggled"
    if kind == 0:
        chosen = {
            "combination": ("sum", "normalized", "max")[random.integers(3)],
            "edge_weight": ("mean", "difference")[random.integers(2)],
            "edge_cost_factor": float(random.integers(3)),
            "default_layer": name if random.uniform() < 0.3 else "",
        }
        settings.update(chosen)
        mesh_map.set_settings(**chosen)
        return "", False
    if kind == 1 or mesh_map.layers[name].READS_LAYERS and kind > 2:
        values = {"factor": float(random.integers(3)) / 2}
    elif kind == 2:
        values = {"combination_weight": float(random.integers(3)) / 2}
    elif kind == 3:
        values = {"threshold": float(random.uniform(0, 6))}
    elif kind == 4:
        values = {"scale": float(random.uniform(0, 2)), "threshold": float(random.uniform(0, 6))}
    else:
        changed = random.integers(0, count, random.integers(0, 5))
        costs = data.get(name, np.zeros(count, np.float32)).copy()
        costs[changed] = random.choice([0, 1, 7, np.inf, np.nan], len(changed))
        data[name] = costs
        mesh_map.refresh_layer(name)
        return name, True
    params.setdefault(name, {}).update(values)
    mesh_map.set_layer_parameters(name, values)
    return name, "threshold" in values


@pytest.mark.parametrize("seed", range(12))
def test_changes_are_as_if_computed_anew(toys, seed):  # noqa: F811
    random = np.random.default_rng(seed)
    shared = grid_map(7).geometry
    mesh_map = MeshMap.of(shared)
    config = random_config(random, int(random.integers(2, 9)))
    for part in config:
        if part["type"] == "data":
            toys[part["name"]] = random.choice([0, 1, 3, 6, np.nan], 49).astype(np.float32)
    mesh_map.compute_layers(config)
    assert not mesh_map.layer_errors and len(mesh_map.layers) == len(config)
    told = {name: layer.result.costs.copy() for name, layer in mesh_map.layers.items()}
    told["Combined Costs"] = mesh_map.costs.copy()
    changes_heard = []
    mesh_map.add_listener(changes_heard.append)
    params, settings = {}, {}
    for _ in range(25):
        calls.clear()
        before = {name: layer.result for name, layer in mesh_map.layers.items()}
        name, own = random_change(random, mesh_map, toys, params, settings)
        counted = evaluations()
        check_evaluations(mesh_map, before, name, own, counted)
        check_told(mesh_map, told, changes_heard)
        fresh = MeshMap.of(shared)
        fresh.set_settings(**settings)
        fresh.compute_layers(
            [
                dict(part, params=dict(part["params"], **params.get(part["name"], {})))
                for part in config
            ]
        )
        assert_same(mesh_map, fresh)


def check_evaluations(mesh_map, before, name, own, counted):
    """Each at most once; only those that depend on what has changed, and all of these."""
    assert set(counted.values()) <= {1}
    readers = readers_of(mesh_map, name) if name else set()
    assert set(counted) <= readers | ({name} if own else set())
    changed = {
        other for other, layer in mesh_map.layers.items() if layer.result is not before[other]
    }
    disabled = {other for other in mesh_map.layers if not mesh_map.layers[other].params["enabled"]}
    if own and name not in disabled:
        assert name in counted
    assert changed <= set(counted) | disabled
    for other in mesh_map.layers:
        if other != name and own and other not in disabled:
            inputs = inputs_of(mesh_map, other)
            weighed = mesh_map.layers[other].READS_WEIGHTS and own == "toggled" and name in inputs
            assert (other in counted) == bool(changed & inputs or weighed)


def check_told(mesh_map, told, changes_heard):
    """What listeners are told leads from the costs before to those now, and not a vertex more."""
    assert len(changes_heard) <= 1
    for changes in changes_heard:
        names = [change.name for change in changes]
        order = list(mesh_map.layers) + ["Combined Costs"]
        assert names and sorted(names, key=order.index) == names and len(set(names)) == len(names)
        for change in changes:
            known = told[change.name]
            differ = np.flatnonzero(
                (known != change.costs) & ~(np.isnan(known) & np.isnan(change.costs))
            )
            layer = mesh_map.layers.get(change.name)
            vectors = layer is not None and layer.result.vectors is not None
            if vectors or layer is not None and not layer.params["enabled"]:  # or they have gone
                assert set(differ) <= set(change.vertices)
            else:
                assert np.array_equal(differ, change.vertices)
            known[change.vertices] = change.costs[change.vertices]
    changes_heard.clear()
    for name, costs in told.items():
        now = mesh_map.costs if name == "Combined Costs" else mesh_map.layers[name].result.costs
        assert np.array_equal(costs, now, equal_nan=True)


REAL = [
    ("final", "MaxCombination", {"inputs": ["spread", "sum"]}),
    ("steps", "HeightDiff", {}),
    ("rough", "Roughness", {}),
    ("sum", "AvgCombination", {"inputs": ["steps", "rough"]}),
    ("steep", "Steepness", {}),
    ("spread", "Inflation", {"inputs": ["steps", "steep"], "inflation_radius": 1.0}),
    ("mean", "WeightedCombination", {}),
    ("all", "Inflation", {"repulsive_field": False}),
]


def random_real_change(random):
    """A layer, and parameters for it."""
    return [
        ("steps", {"threshold": float(random.uniform(0.1, 0.6))}),
        ("steps", {"radius": float(random.uniform(0.1, 0.6))}),
        ("rough", {"threshold": float(random.uniform(0.1, 0.6)), "factor": 0.5}),
        ("steep", {"threshold": float(random.uniform(0.3, 0.6))}),
        ("steep", {"combination_weight": float(random.uniform())}),
        ("spread", {"inscribed_radius": float(random.uniform(0.1, 0.6))}),
        ("spread", {"fading": ("cosine", "exponential")[random.integers(2)]}),
        ("all", {"inflation_radius": float(random.uniform(0.3, 0.8))}),
    ][random.integers(8)]


@pytest.mark.parametrize("seed", range(3))
def test_our_own_layers_too(seed):
    random = np.random.default_rng(seed)
    mesh = terrain(25)
    mesh_map = MeshMap(mesh.vertices, mesh.faces)
    params = {name: dict(given) for name, _, given in REAL}

    def config():
        return [entry(name, "mesh_layers/%sLayer" % kind, **params[name]) for name, kind, _ in REAL]

    mesh_map.compute_layers(config())
    assert list(mesh_map.layers) == "steps rough sum steep spread final mean all".split()
    changed = 0
    for _ in range(15):
        name, values = random_real_change(random)
        params[name].update(values)
        before = mesh_map.planning_costs().version
        mesh_map.set_layer_parameters(name, values)
        changed += mesh_map.planning_costs().version > before
        fresh = MeshMap.of(mesh_map.geometry)
        fresh.compute_layers(config())
        assert_same(mesh_map, fresh)
    assert changed > 3


def test_vectors_that_are_all_zero_and_none():
    """With nothing lethal the vectors of an inflation are zeros; without vectors there are none."""
    mesh_map = MeshMap.of(grid_map(5).geometry)
    for repulsive in (True, False, True):
        config = [entry("all", "mesh_layers/InflationLayer", repulsive_field=repulsive)]
        if not mesh_map.layers:
            mesh_map.compute_layers(config)
        mesh_map.set_layer_parameters("all", {"repulsive_field": repulsive})
        fresh = MeshMap.of(mesh_map.geometry)
        fresh.compute_layers(config)
        assert_same(mesh_map, fresh)
