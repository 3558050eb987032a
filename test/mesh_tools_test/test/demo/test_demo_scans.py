"""The demo of scans, as far as it needs no ROS master."""
import io

import numpy as np
import pytest
from mesh_map.commands import record_scans
from mesh_msgs.outdoor_world import outdoor_world
from mesh_msgs_hdf5.commands.mesh_tool import run_here
from mesh_msgs_hdf5.labels.map_contents import open_map
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_tools_test.demo import layers, main, pipeline, scans
from mesh_tools_test.demo.report import Report

DRIVE = ["--scans", "30", "--rings", "16", "--columns", "360", "--count", "4", "-q"]
VERB = ["record-scans", record_scans.__name__, "mesh_map", ""]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A folder with a bag and a folder of clouds, of the same drive."""
    folder = tmp_path_factory.mktemp("recorded")
    world = outdoor_world(10_000, size=24.0, trees=False)
    mesh = Mesh(vertices=world.vertices, faces=world.faces, vertex_colors=world.colors)
    MapFile.write(str(folder / "world.h5"), mesh)
    for output in ("garden.bag", "garden"):
        assert run_here(VERB, [str(folder / "world.h5"), str(folder / output), *DRIVE]) == 0
    return folder


@pytest.mark.parametrize("name", ["garden.bag", "garden"])
def test_scans_become_a_map_with_layers_and_two_poses(recorded, tmp_path, name):
    said = io.StringIO()
    made = pipeline.prepare(Report(said), tmp_path, recorded / name, 0, 0)
    assert made.path == tmp_path / "garden.h5" and "30 scans" in said.getvalue()
    assert [path.name for path in tmp_path.iterdir()] == ["garden.h5"]
    # What is stored is what the server is told to compute, and the map says what it is made of.
    assert made.layers == layers.FOR_SCANS
    assert set(made.mesh_map.layers) == {entry["name"] for entry in layers.FOR_SCANS}
    stored = open_map(str(made.path)).members.read()
    assert set(stored.vertex_costs) == set(made.mesh_map.layers)
    assert stored.source["inputs"][0]["scans"] == 30 and stored.frame_id == "map"
    assert stored.vertex_colors is not None and "observations" in stored.vertex_attributes
    assert np.linalg.norm(made.goal - made.start) > 5.0
    for place in made.start, made.goal:
        vertex, away = made.mesh_map.nearest_vertex(place, max_distance=0.1)
        assert away == 0.0 and made.mesh_map.costs[vertex] <= pipeline.COST_LIMIT


def test_a_frame_of_the_robot_itself_is_not_that_of_the_map(recorded, tmp_path, monkeypatch):
    run = scans.command.run

    def in_odom(arguments):
        arguments.frame = "odom"
        return run(arguments)

    monkeypatch.setattr(scans.command, "run", in_odom)
    said = io.StringIO()
    path = tmp_path / "garden.h5"
    mesh = scans.reconstruct(Report(said), recorded / "garden", path)
    assert mesh.frame_id == "map" and "frame odom, which the simulated robot" in said.getvalue()


def test_what_cannot_be_reconstructed_is_said_with_the_way_out(tmp_path, capsys):
    clouds = tmp_path / "clouds"
    clouds.mkdir()
    gone = tmp_path / "gone.bag"
    for file in (clouds, gone):
        assert main.main(["--output", str(tmp_path / "out"), str(file)]) == 1
        failures = capsys.readouterr().err
        assert failures.startswith("demo: error: %s: " % file) and failures.count("\n") == 1
        assert "rosrun mesh_map reconstruct %s %s.h5" % (file, file.stem) in failures


@pytest.mark.parametrize("code", [130, 143])
def test_a_demo_that_is_stopped_while_it_reconstructs_ends(tmp_path, monkeypatch, code):
    monkeypatch.setattr(scans.command, "run", lambda _: code)
    with pytest.raises(SystemExit) as ended:
        main.main(["--output", str(tmp_path / "out"), "scans.bag"])
    assert ended.value.code == code
