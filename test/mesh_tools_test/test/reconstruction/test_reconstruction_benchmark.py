"""The benchmark of reconstruction measures what it says."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from mesh_map.scans.odometry_drift import OdometryDrift
from mesh_map.scans.trajectory import Trajectory
from mesh_tools_test.reconstruction import accuracy, bags_ros, fields, peers, pictures, poses
from mesh_tools_test.reconstruction.scene import TOLERANCE, Scene, one_of_each_cell

SCRIPT = Path(__file__).resolve().parents[2] / "benchmark/reconstruction.py"
SMALL = ("--faces", "20000", "--scans", "4", "--columns", "64", "--repeats", "1")


@pytest.fixture(scope="module")
def scene():
    return Scene(20_000, 4, 128)


def test_places_that_rays_reached_are_on_the_truth_and_apart(scene):
    away = scene.world.mesh.spatial_index.closest_batch(points=scene.reached).distances
    assert away.max() < 1e-4 and len(scene.reached) > 5_000
    cells = np.floor(scene.reached / TOLERANCE).astype(np.int64)
    assert len(np.unique(cells, axis=0)) == len(cells)
    truth = scene.world.mesh
    exact = scene.measured(truth.vertices, truth.faces)
    assert exact.missing == 0 and exact.comparison.accuracy.max < 1e-5


def test_what_is_missing_is_counted(scene):
    """Half of the world: the other half is missing, up to TOLERANCE beside it."""
    truth = scene.world.mesh
    west = truth.faces[(truth.vertices[truth.faces][:, :, 0] < 0).all(axis=1)]
    east = 100 * (scene.reached[:, 0] > TOLERANCE).mean()
    assert east - 1 < scene.measured(truth.vertices, west).missing < east + 5


def test_one_point_of_each_cell_stays():
    points = np.array([[0.01, 0, 0], [0.04, 0, 0], [-0.01, 0, 0], [0.06, 0, 0]], np.float32)
    assert one_of_each_cell(points, 0.05).tolist() == points[[0, 2, 3]].tolist()


def test_figures_of_the_surface_stand_beside_it_as_extracted(scene):
    found = {each.name.strip(): each for each in accuracy.measure(scene, 1)}
    loops = found["border loops"]
    assert loops.floor == found["of the truth"].value + 10 == 11
    assert loops.value < loops.peer_value and found["under 1 m around"].value < loops.value
    assert found["non-manifold edges"].value == found["border edges in none"].value == 0
    assert found["accuracy, voxel 0.10 m: mean"].value < found["95 %"].value < 100
    usual, raw = (len(faces) for faces in (scene.mesh.faces, scene.surface.faces))
    assert (found["faces"].value, found["faces"].peer_value) == (usual, raw)


def test_memory_is_that_of_the_field(scene):
    of_field, of_process = fields.memory(scene, 0.2)
    assert of_field == scene.field(0.2).memory
    assert of_process > 0.5 * of_field


def test_drift_ends_where_it_is_to_end(scene):
    truth = scene.world.sensor
    drift = poses.drift_that_ends(truth, 0.5)
    end = drift.of(truth, 0).positions[-1] - truth.positions[-1]
    assert np.linalg.norm(end) == pytest.approx(0.5, abs=1e-3)
    assert drift.yaw / poses.DRIFT.yaw == pytest.approx(drift.slip / poses.DRIFT.slip)


def test_errors_of_poses():
    line = Trajectory([0.0, 1.0], [[0, 0, 0], [3.0, 0, 0]], [[0, 0, 0, 1.0]] * 2)
    turned = OdometryDrift(yaw=0.1).of(line).poses(line.times)
    truths = line.poses(line.times)
    assert poses.turn_errors(turned, truths) == pytest.approx([0, np.degrees(0.3)])
    assert poses.position_errors(turned, truths)[0] == 0
    assert poses.rms(np.array([3.0, 4.0])) == pytest.approx(np.sqrt(12.5))


def test_a_bag_becomes_a_map(scene, tmp_path):
    figures = bags_ros.measure(scene, int(1e6 * scene.points))
    found = {each.name.strip(): each.value for each in figures}
    assert found["faces of the map"] > 500 and found["memory at most"] > 50
    assert figures[0].floor == 60 and 0 < figures[0].value
    with pytest.raises(RuntimeError, match="nothing.bag"):
        bags_ros.reconstructed(str(tmp_path / "nothing.bag"), str(tmp_path / "map.h5"))


def test_poisson_invents_ground(scene):
    found = peers.poisson_surface(scene, 0.4)
    if found is None:
        pytest.skip("python3-open3d is not installed")
    assert found.quality.comparison.accuracy.p95 > scene.quality.comparison.accuracy.p95


def test_refined_poses_are_nearer_to_the_truth(scene):
    there_and_back = "start", (-0.33, 0.03)
    found = {each.name.strip(): each for each in poses.measure(scene, there_and_back, 0.2)}
    errors = found["poses off the truth: RMS"]
    assert 0 < 2 * errors.value < errors.peer_value < 0.2
    assert 15 < found["length of the loop"].value < 30
    assert found["loops closed"].value > 0 == found["onto nothing"].value


def test_pictures_are_made_as_users_make_them(scene, tmp_path):
    made = pictures.write_pictures(scene, tmp_path, ["steepness"])
    names = "clouds.png truth.png mesh.png error.png layer_steepness.png"
    assert [path.name for path in made] == names.split()
    assert all(path.read_bytes()[:4] == b"\x89PNG" for path in made)


def test_the_command_prints_and_writes_figures(tmp_path):
    command = [str(SCRIPT), *SMALL, "--only", "field", "--json", str(tmp_path / "f.json")]
    text = subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout.decode()
    found = {each["name"]: each for each in json.loads((tmp_path / "f.json").read_text())}
    assert found["integrate and extract, voxel 0.05 m"]["peer"] == "one thread"
    # Floors hold for another world.
    assert all(each["value"] > 0 and each["floor"] is None for each in found.values())
    assert all(name in text for name in found)
