"""Layers in map files that do not say how they were made: as the released programs store them."""

import logging
import math
import os

import h5py
import numpy as np
import pytest
from mesh_map.base.plugins import find_class
from mesh_map.costs.layer import BASE_CLASS_TYPE
from mesh_map.io.map_parameters import map_parameters
from mesh_map.io.map_source import MapSource
from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from meshes import terrain

HEIGHT_DIFF = {"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"}
MARKED = np.linspace(0, 0.6, 144).astype(np.float32)
NAMES = {
    "mesh_layers/HeightDiffLayer": "height_diff",
    "mesh_layers/RoughnessLayer": "roughness",
    "mesh_layers/SteepnessLayer": "steepness",
    "mesh_layers/RidgeLayer": "ridge",
    "mesh_layers/BorderLayer": "border",
}


def write_released(path, layers, schema="channels"):
    """As LVR2 and mesh_map write: no UUID, no parameters; in two dimensions."""
    mesh = terrain(12)
    with h5py.File(path, "w") as file:
        group = file.create_group("mesh")
        group.attrs["IO"], group.attrs["CLASS"] = "MeshIO", "MeshBuffer"
        group[schema + "/vertices"] = mesh.vertices
        group[schema + "/face_indices"] = mesh.faces
        place = "channels" if schema == "channels" else "vertex_attributes"
        for name, costs in layers.items():
            group["%s/%s" % (place, name)] = np.asarray(costs, np.float32)[:, None]
    return path


def loaded(path, layers=(HEIGHT_DIFF,), require_provenance=False, **options):
    source = MapSource(path)
    source.require_provenance = require_provenance
    mesh_map = source.make_map(**options)
    mesh_map.compute_layers(
        list(layers), stored=source.stored_costs, on_trust=source.costs_on_trust
    )
    return source, mesh_map


def costs_of(path, layers=(HEIGHT_DIFF,), **options):
    return loaded(path, layers, **options)[1].layers[layers[0]["name"]].result.costs


@pytest.fixture
def path(tmp_path):
    return str(tmp_path / "map.h5")


@pytest.mark.parametrize("schema", ["channels", "geometry"])
@pytest.mark.parametrize("kind", NAMES)
def test_a_released_layer_is_used_and_said_in_one_line(path, kind, schema, caplog):
    write_released(path, {NAMES[kind]: MARKED}, schema)
    layer = {"name": "mine", "type": kind}  # found by the name of its type, not by its own
    _, mesh_map = loaded(path, [layer])
    assert np.array_equal(mesh_map.layers["mine"].result.costs, MARKED)
    (line,) = [r.getMessage() for r in caplog.records if r.levelno >= logging.WARNING]
    assert line.startswith("layer mine is taken on trust: ") and " %s," % NAMES[kind] in line
    assert "does not say with which parameters and for which geometry" in line
    assert "require_provenance: true" in line
    threshold = mesh_map.layers["mine"].params["threshold"]
    lethal = MARKED > np.float32(threshold)
    assert np.array_equal(mesh_map.layers["mine"].result.lethal, lethal) and lethal.any()


def test_require_provenance_refuses_them(path, caplog):
    caplog.set_level(logging.INFO, "mesh_map")
    write_released(path, {})
    fresh = costs_of(path)
    write_released(path, {"height_diff": MARKED})
    assert np.array_equal(costs_of(path, require_provenance=True), fresh)
    (line,) = [r.getMessage() for r in caplog.records if "computed anew" in r.getMessage()]
    assert line == (
        "layer height_diff is computed anew: the file does not say how, and for which geometry, "
        "the costs of height_diff were computed"
    )
    assert map_parameters({"mesh_file": path}).require_provenance is False
    values = {"mesh_file": path, "require_provenance": True}
    assert map_parameters(values).require_provenance is True


def test_the_name_of_the_layer_does_not_count_but_that_of_its_type(path):
    write_released(path, {})
    fresh = costs_of(path)
    write_released(path, {"roughness": MARKED, "mine": MARKED})
    layer = {"name": "roughness", "type": "mesh_layers/HeightDiffLayer"}
    assert np.array_equal(costs_of(path, [layer]), fresh)
    assert np.array_equal(costs_of(path, [dict(layer, name="mine")]), fresh)


@pytest.mark.parametrize(
    "kind, value, said",
    [
        ("mesh_layers/SteepnessLayer", 3.2, "3.2 is more than the 3.14159"),
        ("mesh_layers/RoughnessLayer", 90.0, "90 is more than"),
        ("mesh_layers/HeightDiffLayer", 1e3, "1000 is more than"),
        ("mesh_layers/BorderLayer", 11.0, "11 is more than the 10"),
        ("mesh_layers/RidgeLayer", math.nan, "none is known"),
        ("mesh_layers/HeightDiffLayer", -0.5, "negative"),
    ],
)
def test_values_that_cannot_be_of_the_type_are_refused(path, kind, value, said, caplog):
    costs = np.full(144, math.nan) if math.isnan(value) else MARKED.copy()
    costs[7] = value
    write_released(path, {})
    fresh = costs_of(path, [{"name": "mine", "type": kind}])
    caplog.clear()
    write_released(path, {NAMES[kind]: costs})
    found = costs_of(path, [{"name": "mine", "type": kind}])
    assert np.array_equal(found, fresh, equal_nan=True)
    assert "layer mine is computed anew: " in caplog.text and said in caplog.text


def test_unknown_and_lethal_values_are_none_that_do_not_fit(path):
    costs = MARKED.copy()
    costs[:2] = math.inf, -math.inf  # the release has -inf where nothing is around
    write_released(path, {"height_diff": costs})
    found = costs_of(path)
    assert found[0] == math.inf and math.isnan(found[1]) and np.array_equal(found[2:], costs[2:])


def test_another_number_of_vertices_is_no_layer(path):
    write_released(path, {})
    fresh = costs_of(path)
    write_released(path, {"height_diff": MARKED[:-1]})
    assert np.array_equal(costs_of(path), fresh)


@pytest.mark.parametrize(
    "options", [{"up_direction": [0, 1, 0]}, {"orient": True}, {"max_edge_length": 0.05}]
)
def test_another_view_of_the_geometry_is_computed(path, options):
    write_released(path, {})
    fresh = costs_of(path, **options)
    write_released(path, {"height_diff": MARKED})
    assert np.array_equal(costs_of(path, **options), fresh)


def test_layers_that_read_others_are_computed(path):
    """What is lethal now, and how far from it the robot must be, costs of then do not know."""
    write_released(path, {"riskiness": MARKED, "inflation": MARKED})
    inflation = {"name": "inflation", "type": "mesh_layers/InflationLayer"}
    found = costs_of(path, [dict(inflation, params={"repulsive_field": False})])
    assert not np.array_equal(found, MARKED)


def test_every_type_that_the_release_stores_has_its_name():
    for kind, name in NAMES.items():
        assert find_class("mesh_map", BASE_CLASS_TYPE, kind).RELEASED_NAME == name


def test_costs_that_say_something_are_never_taken_on_trust(tmp_path):
    mesh = terrain(12)
    file = MapFile.write(str(tmp_path / "a.h5"), Mesh(mesh.vertices, mesh.faces))
    fresh = costs_of(file.path)
    for parameters in ({"geometry": "f00"}, {"radius": 0.3}, {"geometry": file.uuid}):
        file.write_layers({"height_diff": (MARKED, parameters)})
        assert np.array_equal(costs_of(file.path), fresh)


def test_trust_does_not_become_proof_by_saving(tmp_path):
    mesh = terrain(12)
    file = MapFile.write(str(tmp_path / "a.h5"), Mesh(mesh.vertices, mesh.faces))
    file.write_layers({"height_diff": (MARKED, None)})
    source, mesh_map = loaded(file.path)
    mesh_map.set_layer_parameters("height_diff", {"threshold": 0.4})
    assert np.array_equal(mesh_map.layers["height_diff"].result.costs, MARKED)
    layers, errors = mesh_map.layers_to_store()
    assert source.save_layers(layers) == ["height_diff"] and not errors
    assert set(file.layer_parameters("height_diff")) == {"layer_info"}
    again = costs_of(file.path, require_provenance=True)
    assert not np.array_equal(again, MARKED)
    # computed, it is proven from then on
    mesh_map.set_layer_parameters("height_diff", {"radius": 0.5})
    source.save_layers(mesh_map.layers_to_store()[0])
    assert file.layer_parameters("height_diff")["radius"] == 0.5
    wide = dict(HEIGHT_DIFF, params={"radius": 0.5})
    found = costs_of(file.path, [wide], require_provenance=True)
    assert np.array_equal(found, mesh_map.layers["height_diff"].result.costs)
    assert os.listdir(tmp_path) == ["a.h5"]


@pytest.mark.parametrize("way", ["ply", "edited ply", "glb", "edited glb", "repaired"])
def test_only_of_map_files_not_of_what_passed_through_other_programs(path, way):
    """Our own exports come back as they were, as long as the geometry does."""
    write_released(path, {"height_diff": MARKED})
    suffix, new = way.split()[-1], path + "_new.h5"
    if way == "repaired":
        with h5py.File(path, "r+") as file:
            faces = file["mesh/channels/face_indices"][()]
            del file["mesh/channels/face_indices"]
            file["mesh/channels/face_indices"] = np.concatenate([faces, faces[-1:]])
        words = ["import", path, new, "--repair"]
    else:
        words = ["import", "%s.%s" % (path, suffix), new]
        assert main(["export", path, words[1], "-q"]) == 0
    if way == "edited ply":  # comments are gone, and vertices are elsewhere
        with open(words[1], "rb") as stream:
            head, rows = stream.read().split(b"end_header\n", 1)
        lines = [line for line in head.split(b"\n") if not line.startswith(b"comment")]
        first = np.frombuffer(rows[:12], "<f4") + np.float32(0.5)
        with open(words[1], "wb") as stream:
            stream.write(b"\n".join(lines) + b"end_header\n" + first.tobytes() + rows[12:])
    if way == "edited glb":  # as a program that keeps the extras would
        with open(words[1], "r+b") as stream:
            data = stream.read()
            place = data.index(MARKED.tobytes()) - 144 * 12
            stream.seek(place)
            stream.write((np.frombuffer(data[place : place + 4], "<f4") + 1).tobytes())
    assert main([*words, "-q"]) == 0
    used = np.array_equal(costs_of(new), MARKED)
    assert used == (way in ("ply", "glb"))
    assert ("carried_by" in MapFile(new).layer_parameters("height_diff")) != used
    stored = {"name": "height_diff", "type": "mesh_layers/StoredLayer", "threshold": 9.0}
    assert np.array_equal(costs_of(new, [stored]), MARKED)


@pytest.mark.parametrize("words", [["rename"], ["copy"], ["copy", "--from"]])
def test_a_name_that_is_trusted_is_not_had_by_renaming(path, tmp_path, words):
    write_released(path, {})
    assert main(["convert", path, path + "_s1.h5", "-q"]) == 0
    path += "_s1.h5"
    fresh = costs_of(path)
    MapFile(path).write_layers({"mine": (MARKED, {})})
    line = ["layers", words[0], path, "mine", "height_diff", "-q"]
    assert main(line + (["--from", path] if "--from" in words else [])) == 0
    assert np.array_equal(costs_of(path), fresh)
    assert np.array_equal(MapFile(path).vertex_costs("height_diff"), MARKED)


def test_the_log_says_who_carried_them(path, caplog):
    caplog.set_level(logging.INFO, "mesh_map")
    mesh = terrain(12)
    mesh = Mesh(mesh.vertices, mesh.faces, vertex_costs={"height_diff": MARKED})
    mesh.layer_parameters = {"height_diff": {"carried_by": "crop"}}
    MapFile.write(path, mesh)
    costs_of(path)
    assert "computed anew: its costs in the file were carried there by crop" in caplog.text
