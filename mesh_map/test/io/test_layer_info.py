"""What is told of the meaning of costs: it is what layers do."""

import math

import genpy
import numpy as np
import pytest
from mesh_map.costs.combination import COMBINED_COSTS
from mesh_map.costs.layer import Layer, LayerResult
from mesh_map.costs.lethal_rule import LethalRule
from mesh_map.io.map_messages import layer_info_message
from mesh_map.io.map_source import MapSource
from mesh_map.map.mesh_map import MeshMap
from mesh_msgs import zoo
from mesh_msgs.msg import LayerInfo
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.layer_meaning import meaning_of
from mesh_msgs_hdf5.model.mesh import Label, Mesh
from mesh_msgs_hdf5.ros.map_messages import MapMessages

WORLD = zoo.outdoor_world(faces=20_000)
GEOMETRIC = [
    ("height_diff", "HeightDiffLayer", "m", LayerInfo.ABOVE, {"threshold": 0.2, "radius": 0.5}),
    ("roughness", "RoughnessLayer", "rad", LayerInfo.ABOVE, {"threshold": 0.2}),
    ("steepness", "SteepnessLayer", "rad", LayerInfo.ABOVE, {"threshold": 0.5}),
    ("ridge", "RidgeLayer", "m", LayerInfo.ABOVE, {"threshold": 0.4}),
    ("border", "BorderLayer", "", LayerInfo.ABOVE, {}),
    ("clearance", "ClearanceLayer", "", LayerInfo.AT_LEAST, {}),
    ("collision", "CollisionLayer", "", LayerInfo.AT_LEAST, {}),
    ("forbidden", "LabelLayer", "", LayerInfo.NONE, {"lethal": ["forbidden"]}),
    ("stored", "StoredLayer", "", LayerInfo.ABOVE, {"layer": "values", "threshold": 3.0}),
    ("all_stored", "StoredLayer", "", LayerInfo.NONE, {"layer": "values"}),
    ("obstacle", "ObstacleLayer", "", LayerInfo.NONE, {}),
    ("inflation", "InflationLayer", "", LayerInfo.AT_LEAST, {"lethal_value": 2.0}),
    ("endless", "InflationLayer", "", LayerInfo.NONE, {"lethal_value": -1}),
    # Costs within its inscribed radius are as large as those that are lethal.
    ("odd", "InflationLayer", "", LayerInfo.OTHER, {"lethal_value": 1.0, "inscribed_value": 1.0}),
]


@pytest.fixture(scope="module")
def mesh_map(tmp_path_factory):
    values = np.linspace(0.0, 5.0, len(WORLD.vertices), dtype=np.float32)
    values[3] = math.inf
    values[60:70] = math.nan
    mesh = Mesh(WORLD.vertices, WORLD.faces, vertex_costs={"values": values})
    mesh.labels["forbidden_1"] = Label(np.arange(30, dtype=np.uint32))
    path = MapFile.write(str(tmp_path_factory.mktemp("map") / "map.h5"), mesh).path
    made = MapSource(path).make_map()
    made.compute_layers(
        [
            {"name": name, "type": "mesh_layers/" + kind, "params": params}
            for name, kind, _, _, params in GEOMETRIC
        ]
    )
    assert not made.layer_errors
    return made


def told(mesh_map, **others):
    message = layer_info_message(mesh_map, 1.5, others)
    assert message.uuid == mesh_map.uuid and message.header.frame_id == mesh_map.frame_id
    return {one.name: one for one in message.layers}


@pytest.mark.parametrize(
    "name, kind, unit, comparison, params", GEOMETRIC, ids=lambda v: str(v)[:8]
)
def test_what_is_told_is_what_is_lethal(mesh_map, name, kind, unit, comparison, params):
    info, (costs, lethal, _) = told(mesh_map)[name], mesh_map.layers[name].result
    assert (info.layer_type, info.unit) == ("mesh_layers/" + kind, unit)
    assert info.comparison == comparison and info.infinity == "lethal"
    assert info.lethal == np.count_nonzero(lethal)
    assert info.unknown == np.count_nonzero(np.isnan(costs))
    assert math.isnan(info.cost_limit)
    assert math.isnan(info.threshold) == (comparison in (LayerInfo.NONE, LayerInfo.OTHER))
    threshold = np.float32(info.threshold)
    follows = {
        LayerInfo.NONE: np.zeros(len(costs), bool),
        LayerInfo.ABOVE: costs > threshold,
        LayerInfo.AT_LEAST: costs >= threshold,
    }
    if comparison in follows:
        assert np.array_equal(follows[comparison] | np.isposinf(costs), lethal)
    assert name == "obstacle" or info.lethal > 0  # which has seen nothing


def test_combined_costs_and_others(mesh_map):
    found = told(mesh_map, Potential="not reached")
    assert list(found)[-2:] == [COMBINED_COSTS, "Potential"]
    combined, costs = found[COMBINED_COSTS], mesh_map.planning_costs().costs
    assert (combined.cost_limit, combined.infinity) == (1.5, "lethal")
    assert combined.lethal == np.count_nonzero(np.isposinf(costs)) > 0
    assert combined.unknown == np.count_nonzero(np.isnan(costs))
    potential = found["Potential"]
    assert (potential.infinity, potential.layer_type) == ("not reached", "")
    assert math.isnan(potential.cost_limit) and math.isnan(potential.threshold)


def test_what_is_stored_says_the_same(mesh_map, tmp_path):
    path = MapFile.write(str(tmp_path / "map.h5"), Mesh(WORLD.vertices, WORLD.faces)).path
    names = MapSource(path).save_layers(mesh_map.layers)
    assert "steepness" in names and "odd" in names
    messages = MapMessages(MapFile(path), mesh_map.uuid, genpy.Time())
    stored = {info.name: info for info in messages.layer_info().layers}
    assert sorted(stored) == sorted(names)
    for name, info in told(mesh_map).items():
        assert name not in stored or repr(stored[name]) == repr(info)


def test_of_a_derived_mesh_the_numbers_are_those_of_the_stored_vertices(tmp_path):
    grid = zoo.grid()
    path = MapFile.write(str(tmp_path / "map.h5"), Mesh(grid.vertices, grid.faces)).path
    source = MapSource(path)
    made = source.make_map(max_edge_length=0.5 * float(np.ptp(grid.vertices[:, 0])) / 10)
    made.compute_layers([{"name": "border", "type": "mesh_layers/BorderLayer"}])
    source.save_layers(made.layers)
    file = MapFile(path)
    meaning = meaning_of(file.layer_parameters("border"))
    costs = file.vertex_costs("border")
    assert len(costs) == len(grid.vertices) < len(made.vertices)
    assert meaning.lethal == np.count_nonzero(meaning.lethal_in(costs)) > 0
    assert meaning.unknown == np.count_nonzero(np.isnan(costs))


class LyingLayer(Layer):
    """Lethal is something else than what it says."""

    UNIT = "N"

    def compute(self, mesh_map, inputs):
        costs = np.arange(len(mesh_map.vertices), dtype=np.float32)
        return LayerResult(costs, costs == 5)

    def lethal_rule(self):
        return LethalRule(4.0)


def test_a_rule_that_is_not_kept_is_not_told():
    grid = zoo.grid()
    mesh_map = MeshMap(grid.vertices, grid.faces)
    mesh_map.compute_layers([])
    layer = LyingLayer("lying")
    layer.result = layer.evaluate(mesh_map, {})
    mesh_map.layers["lying"] = layer
    info = told(mesh_map)["lying"]
    assert (info.comparison, info.lethal, info.unit) == (LayerInfo.OTHER, 1, "N")
    assert math.isnan(info.threshold)
