"""Layers for tests of what follows from what: cheap, exact, and counted."""

from collections import Counter

import numpy as np
import pytest
from mesh_map import MeshMap
from mesh_map.base.parameter import Parameter
from mesh_map.costs import layer_set
from mesh_map.costs.layer import Layer, LayerResult
from mesh_map.layers.combination_layer import (
    MaxCombinationLayer,
    SumCombinationLayer,
    WeightedCombinationLayer,
)

calls = Counter()  # (name of the layer, method) -> how often


class DataLayer(Layer):
    """Costs that the test sets in `data`, times `scale`, lethal above `threshold`."""

    PARAMETERS = (
        Parameter("scale", 1.0, 0.0, 10.0),
        Parameter("threshold", 5.0, 0.0, 100.0, affects_costs=False),
        Parameter("fails", False),
    )
    ALL = {}  # name -> costs, also before there is a layer of that name

    def compute(self, mesh_map, inputs):
        calls[self.name, "compute"] += 1
        if self.params["fails"]:
            raise RuntimeError("it was told to fail")
        data = self.ALL.get(self.name, np.zeros(len(mesh_map.vertices), np.float32))
        return self._result(np.float32(self.params["scale"]) * data)

    def update(self, mesh_map, inputs, changed, before):
        calls[self.name, "update"] += 1
        assert len(changed) == 0 and changed.dtype == np.uint32
        result = self.compute(mesh_map, inputs)
        calls[self.name, "compute"] -= 1
        return result

    def reuse(self, costs, mesh_map, inputs):
        calls[self.name, "reuse"] += 1
        return self._result(costs)

    def _result(self, costs):
        return LayerResult(costs, costs > np.float32(self.params["threshold"]))


class NeighborLayer(Layer):
    """Half of the costs of the inputs, and of their lethal vertices' neighbors 1: what is read of a
    vertex matters to others, as in an inflation. Its vectors say how many inputs are lethal."""

    READS_LAYERS = True
    READS_WEIGHTS = False
    PARAMETERS = (Parameter("share", 0.5, 0.0, 1.0),)

    def announce(self, geometry):
        calls[self.name, "announce"] += 1

    def compute(self, mesh_map, inputs):
        calls[self.name, "compute"] += 1
        return self._at(mesh_map, inputs, np.arange(len(mesh_map.vertices)))

    def update(self, mesh_map, inputs, changed, before):
        calls[self.name, "update"] += 1
        assert len(changed) and (np.diff(changed.astype(np.int64)) > 0).all()
        topology = mesh_map.topology
        around = [changed] + [topology.neighbors_of(vertex) for vertex in changed]
        vertices = np.unique(np.concatenate(around)).astype(np.int64)
        costs, lethal, vectors = (array.copy() for array in before)
        part = self._at(mesh_map, inputs, vertices)
        costs[vertices], lethal[vertices], vectors[vertices] = part
        return LayerResult(costs, lethal, vectors)

    def _at(self, mesh_map, inputs, vertices):
        costs = np.zeros(len(vertices), np.float32)
        vectors = np.zeros((len(vertices), 3), np.float32)
        for read in inputs.values():
            term = np.float32(self.params["share"]) * read.costs[vertices]
            costs += np.where(np.isfinite(term), term, 0).astype(np.float32)
            dead = [read.lethal[mesh_map.topology.neighbors_of(v)].any() for v in vertices]
            costs += np.array(dead, np.float32)
            vectors[:, 2] += read.lethal[vertices]
        return costs, costs > 20, vectors


class FailingLayer(NeighborLayer):
    """As its base, but fails whenever `broken` is set."""

    broken = False

    def compute(self, mesh_map, inputs):
        self._stop()
        return super().compute(mesh_map, inputs)

    def update(self, mesh_map, inputs, changed, before):
        self._stop()
        return super().update(mesh_map, inputs, changed, before)

    def _stop(self):
        if FailingLayer.broken:
            calls[self.name, "failed"] += 1
            raise KeyError("broken")


def counted(base):
    """A layer class that counts."""

    class Counted(base):
        def compute(self, mesh_map, inputs):
            calls[self.name, "compute"] += 1
            return super().compute(mesh_map, inputs)

        def update(self, mesh_map, inputs, changed, before):
            computed = calls[self.name, "compute"]
            found = super().update(mesh_map, inputs, changed, before)
            calls[self.name, "compute"] = computed
            calls[self.name, "update"] += 1
            return found

    return Counted


TYPES = {
    "data": DataLayer,
    "neighbors": NeighborLayer,
    "failing": FailingLayer,
    "sum": counted(SumCombinationLayer),
    "mean": counted(WeightedCombinationLayer),
    "max": counted(MaxCombinationLayer),
}


@pytest.fixture
def toys(monkeypatch):
    """The toy layers are plugins of the names in TYPES, and nothing has been counted."""
    monkeypatch.setattr(layer_set, "find_class", lambda _package, _base, name: TYPES[name])
    monkeypatch.setattr(FailingLayer, "broken", False)
    monkeypatch.setattr(DataLayer, "ALL", {})
    calls.clear()
    return DataLayer.ALL


def entry(name, type_name, inputs=None, **params):
    """An entry of the list of layers."""
    if inputs is not None:
        params["inputs"] = inputs
    return {"name": name, "type": type_name, "params": params}


def evaluations():
    """What has been evaluated since the last call: name -> number of compute() and update()."""
    found = Counter()
    for (name, method), count in calls.items():
        if method in ("compute", "update", "reuse") and count:
            found[name] += count
    calls.clear()
    return dict(found)


def grid_map(side=8):
    """A small plane."""
    x, y = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    vertices = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3).astype(np.float32)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    first = np.stack([corner, corner + side, corner + 1], axis=1)
    second = np.stack([corner + 1, corner + side, corner + side + 1], axis=1)
    return MeshMap(vertices, np.concatenate([first, second]))


CHAIN = [
    entry("ground", "data"),
    entry("water", "data"),
    entry("near", "neighbors", ["water"]),
    entry("all", "sum"),
]


@pytest.fixture
def chain(toys):
    """Two layers of data; one reads one of them, and one all."""
    toys["ground"] = np.linspace(0, 4, 64, dtype=np.float32)
    toys["water"] = np.zeros(64, np.float32)
    toys["water"][10] = 9
    mesh_map = grid_map()
    mesh_map.compute_layers(CHAIN)
    assert not mesh_map.layer_errors
    calls.clear()
    mesh_map.told = []
    mesh_map.add_listener(mesh_map.told.append)
    return mesh_map


def told(mesh_map):
    """Names and numbers of vertices of the only change since the last call."""
    (changes,) = mesh_map.told
    mesh_map.told.clear()
    return [(change.name, len(change.vertices)) for change in changes]
