"""mesh_tool layers compute: what it stores is what mesh_map's node takes."""

import numpy as np
import pytest
from full_map import full_map
from mesh_map.io.map_parameters import map_parameters
from mesh_map.io.map_source import MapSource
from mesh_map.layers.threshold_layer import ThresholdLayer
from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.errors import MapFileError
from verb_calls import call, said

CONFIGURATION = """
layers:
  - {name: steep, type: mesh_layers/SteepnessLayer, threshold: 0.5}
  - {name: height_diff, type: mesh_layers/HeightDiffLayer}
  - {name: inflation, type: mesh_layers/InflationLayer}
height_diff: {radius: 0.25}
inflation: {inputs: [height_diff], inflation_radius: 0.3}
max_edge_length: 0.0
"""


@pytest.fixture
def path(tmp_path):
    MapFile.write(tmp_path / "map.h5", full_map())
    return str(tmp_path / "map.h5")


def loaded(configuration):
    """The layers of a map, as the node makes it of its parameters."""
    parameters = map_parameters(configuration)
    source = MapSource(parameters.mesh_file, parameters.mesh_part, parameters.origin)
    mesh_map = source.make_map(parameters.global_frame, **parameters.geometry)
    mesh_map.compute_layers(parameters.layers, stored=source.stored_costs)
    assert not mesh_map.layer_errors
    return mesh_map.layers


def node_parameters(path):
    return {
        "mesh_file": path,
        "layers": [{"name": "height_diff", "type": "mesh_layers/HeightDiffLayer"}],
        "height_diff": {"radius": 0.25},
    }


def test_the_node_takes_what_was_stored_bit_for_bit(path, capsys, monkeypatch):
    computed = loaded(node_parameters(path))["height_diff"].result.costs  # nothing is stored yet
    words = [path, "height_diff", "--set", "height_diff.radius=0.25"]
    (entry,) = said(capsys, "layers_compute", *words)["layers"]
    assert entry["name"] == "height_diff" and entry["is_new"]
    file = MapFile(path)
    stored = file.vertex_costs("height_diff")
    assert stored.tobytes() == computed.tobytes()
    assert file.layer_parameters("height_diff")["geometry"] == file.uuid
    before = full_map()  # all else is there as it was
    assert file.labels().keys() == before.labels.keys() and file.layer_names()[1:] == ["x"]

    def fail(*_):
        raise AssertionError("it was computed again")

    monkeypatch.setattr(ThresholdLayer, "compute", fail)
    assert loaded(node_parameters(path))["height_diff"].result.costs.tobytes() == stored.tobytes()
    (entry,) = said(capsys, "layers_compute", *words)["layers"]  # nor does the verb
    assert not entry["is_new"]


def test_layers_of_a_configuration(path, tmp_path, capsys):
    (tmp_path / "layers.yaml").write_text(CONFIGURATION)
    words = ["--config", tmp_path / "layers.yaml"]
    entries = said(capsys, "layers_compute", path, "inflation", *words)["layers"]
    assert [entry["name"] for entry in entries] == ["inflation"]
    assert MapFile(path).layer_names() == ["inflation", "x"]  # those that it reads are not stored
    with_inputs = MapFile(path).vertex_costs("inflation")
    assert np.isinf(with_inputs).any() or with_inputs.max() > 0
    entries = said(capsys, "layers_compute", path, *words, "--set", "steep.threshold=0.4")["layers"]
    new = {entry["name"]: entry["is_new"] for entry in entries}
    assert new == {"steep": True, "height_diff": True, "inflation": False}
    assert {entry["name"]: entry["threshold"] for entry in entries}["steep"] == 0.4


def test_a_layer_that_is_named_replaces_the_one_before(path, capsys):
    said(capsys, "layers_compute", path, "height_diff")
    before = MapFile(path).vertex_costs("height_diff")
    (entry,) = said(
        capsys, "layers_compute", path, "height_diff", "--set", "height_diff.radius=0.15"
    )["layers"]
    assert entry["is_new"] and entry["parameters"]["radius"] == 0.15
    assert not np.array_equal(MapFile(path).vertex_costs("height_diff"), before)


def test_what_cannot_be_stored_is_said(path, capsys):
    value = said(capsys, "layers_compute", path, "height_diff", "obstacle", "inflation")
    assert [entry["name"] for entry in value["layers"]] == ["height_diff"] + ["inflation"]
    assert any("not stored: obstacle" in note for note in value["notes"])


@pytest.mark.parametrize(
    "words,text",
    [
        ([], "no layer is named"),
        (["slope"], "there is no type of layers called slope (known: "),
        (["a=none/None"], "layer a: "),
        (["height_diff", "--set", "radius=1"], "NAME.PARAM=VALUE"),
        (["height_diff", "--set", "steep.radius=1"], "there is no layer steep"),
        (
            ["inflation"],
            "layer inflation reads other layers, but none is there (nothing was stored",
        ),
        (
            ["height_diff", "--set", "height_diff.threshhold=1"],
            "layer height_diff has no parameter threshhold (is threshold meant? it has: ",
        ),
        (["--config", "CONFIGURATION", "--set", "steep.radius=1"], "steep has no parameter radius"),
        (["height_diff", "--set", "height_diff.radius=[1"], "is no value"),
        (["height_diff", "--set", "height_diff.radius=wide"], "radius"),
        (["slope", "--config", "CONFIGURATION"], "has no layer slope (it has: steep, height_diff"),
        (["--config", "/none.yaml"], "No such file"),
    ],
)
def test_nothing_is_stored_where_something_is_wrong(path, tmp_path, words, text):
    (tmp_path / "layers.yaml").write_text(CONFIGURATION)
    words = [word.replace("CONFIGURATION", str(tmp_path / "layers.yaml")) for word in words]
    with open(path, "rb") as stream:
        before = stream.read()
    with pytest.raises(MapFileError) as refused:
        call("layers_compute", path, *words)
    assert text in str(refused.value) and "\n" not in str(refused.value)
    with open(path, "rb") as stream:
        assert stream.read() == before


def test_other_formats_are_refused(tmp_path):
    (tmp_path / "a.obj").write_text("v 0 0 0\n")
    with pytest.raises(MapFileError, match="mesh_tool import"):
        call("layers_compute", tmp_path / "a.obj", "height_diff")


def test_as_a_verb_of_mesh_tool(path, capfd):
    """Found by the export of package.xml, in a process of its own."""
    assert main(["layers", "compute", path, "steepness", "-q"]) == 0
    assert capfd.readouterr() == ("", "")
    assert MapFile(path).layer_names() == ["steepness", "x"]
    assert main(["layers", "compute", path, "slope"]) == 1
    out, err = capfd.readouterr()
    assert not out and err.startswith("mesh_tool: error: %s: there is no type" % path)
    assert err.count("\n") == 1


def test_a_wrong_name_of_a_parameter_is_told_before_anything_is_computed(path, monkeypatch):
    def fail(*_):
        raise AssertionError("it was computed")

    monkeypatch.setattr(ThresholdLayer, "compute", fail)
    with pytest.raises(MapFileError, match="no parameter treshold"):
        call("layers_compute", path, "height_diff", "--set", "height_diff.treshold=1")


def test_an_error_names_the_file_once(path):
    with pytest.raises(MapFileError) as refused:
        call("layers_compute", path, "height_diff", "--part", "attic")
    text = str(refused.value)
    assert text.count(path) == 1 and "there is no mesh in /attic" in text and refused.value.hint
