"""The benchmark of the planners measures what it says, and its peers agree with mesh_map."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
from mesh_map.distance.surface_path import SurfacePath
from mesh_map.distance.wave_front import WaveFrontSolver
from mesh_tools_test.planning import fields, peers, plans, success, updates
from mesh_tools_test.planning.world import CostedMap, Place, divided, patch, planning_world

SCRIPT = Path(__file__).resolve().parents[2] / "benchmark/planners.py"


@pytest.fixture(scope="module")
def world():
    return planning_world(8_000)


def test_noise_is_in_the_heights_alone():
    quiet, rough = planning_world(2_000, noise=0.0), planning_world(2_000, noise=0.05)
    offsets = rough.vertices - quiet.vertices
    assert not offsets[:, :2].any()
    assert offsets[:, 2].std() == pytest.approx(0.05, rel=0.1)


def test_places_lie_in_their_faces_on_the_ground(world):
    assert world.ground.mean() > 0.5 and world.ground[world.source]
    for place in world.places(200, np.random.default_rng(1)):
        assert world.ground[world.faces[place.face]].all()
        corners = world.vertices[world.faces[place.face]].astype(np.float64)
        shares = np.linalg.lstsq(
            np.vstack([corners.T, np.ones(3)]), np.append(place.position, 1.0), rcond=None
        )[0]
        assert shares.min() > -1e-6
        np.testing.assert_allclose(shares @ corners, place.position, atol=1e-6)


def test_dividing_faces_keeps_the_surface(world):
    fine = divided(world)
    edges = world.topology.edge_count
    assert len(fine.faces) == 4 * len(world.faces)
    assert len(fine.vertices) == len(world.vertices) + edges
    assert fine.topology.edge_count == 2 * edges + 3 * len(world.faces)
    assert fine.topology.component_count == world.topology.component_count

    def area_vectors(made):
        corners = made.vertices[made.faces].astype(np.float64)
        return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])

    parts = area_vectors(fine).reshape(4, -1, 3)
    np.testing.assert_allclose(parts.sum(axis=0), area_vectors(world), atol=1e-4)


def test_costs_of_a_map_change_with_its_version(world):
    mesh_map = CostedMap(world.geometry, world.costs)
    before = mesh_map.planning_costs()
    changed = patch(world, 50)
    assert len(changed) == 50 and world.source in changed and (np.diff(changed) > 0).all()
    mesh_map.set_costs(changed, 0.75)
    now = mesh_map.planning_costs()
    assert now.version > before.version and (now.costs[changed] == 0.75).all()
    others = np.setdiff1d(np.arange(len(world.vertices)), changed)
    np.testing.assert_array_equal(now.costs[others], before.costs[others])
    assert not (before.costs[changed] == 0.75).all()


def test_scipy_computes_the_same_ways(world):
    figures = fields.fields(world, 1)  # raises where SciPy says something else
    names = [figure.name for figure in figures]
    assert names[1:] == [
        "Dijkstra, whole field",
        "wave front, whole field",
        "wave front with costs",
    ]
    assert [figure.peer for figure in figures[1:3]] == [fields.SCIPY] * 2


def test_peers_agree_where_they_are_installed(world):
    ground = peers.snapshot_of(world)
    own = WaveFrontSolver.of(world.geometry).solve(world.source).labels[ground.numbers]
    solvers = [("exact", lambda: peers.exact_solver(ground))] + peers.installed(ground)
    asked = 0
    for name, prepare in solvers:
        solve = prepare()
        if solve is None:
            continue
        distances = solve(ground.source)
        far = (distances > 3.0) & (distances < 1e9)
        assert far.sum() > 100
        bound = {"exact": 0.01, "potpourri3d FMM": 0.1}.get(name, 0.5)
        assert abs(np.median(own[far] / distances[far]) - 1.0) < bound, name
        asked += 1
    if not asked:
        pytest.skip("neither potpourri3d nor pygeodesic is installed")


def test_ground_near_the_source_is_a_part_of_all(world):
    ground, near = peers.snapshot_of(world), peers.snapshot_of(world, 8.0)
    assert near.numbers[near.source] == ground.numbers[ground.source] == world.source
    assert len(near.numbers) < len(ground.numbers) and np.isin(near.numbers, ground.numbers).all()
    np.testing.assert_array_equal(near.vertices, world.vertices[near.numbers])
    # Every face at a vertex that is near is there.
    offsets = ground.vertices - ground.vertices[ground.source]
    is_near = np.linalg.norm(offsets, axis=1) <= 8.0
    expected = ground.numbers[ground.faces[is_near[ground.faces].any(axis=1)]]
    np.testing.assert_array_equal(near.numbers[near.faces], expected)


def straight(points, potentials, faces=None):
    points = np.array(points, np.float64)
    faces = np.zeros(len(points) - 1, np.uint32) if faces is None else np.array(faces, np.uint32)
    return SurfacePath(points, faces, np.array(potentials, np.float64))


def test_faults_of_paths_are_seen():
    vertices = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]], np.float32)
    faces = np.array([[0, 1, 2]], np.uint32)
    start, goal = (Place(0, np.array([x, 1.0, 0.0])) for x in (0.5, 2.0))
    one, two, far = [0.5, 1, 0], [2, 1, 0], [2, 1, 0.1]

    def found(path):
        return success.fault(path, start, goal, vertices, faces)

    assert found(straight([one, two], [1.5, 0.0])) == ""
    assert found(straight([one, [1, 1.2, 0], two], [2, 1, 0])) == ""
    assert found(None) == "no path"
    assert "begin" in found(straight([two, two], [1.5, 0.0]))
    assert "end" in found(straight([one, far], [1.5, 0.0]))
    assert "fall" in found(straight([one, [1, 1, 0], two], [1.5, 1.5, 0.0]))
    for off in ([1, 1, 0.01], [1, -0.1, 0], [3, 3, 0], [-0.2, 1, 0]):
        assert "surface" in found(straight([one, off, two], [3, 1, 0]))


def test_paths_are_found_at_every_level_of_noise():
    for noise in success.NOISE:
        outcome = success.tried(planning_world(6_000, noise), goals=4, starts=5)
        assert outcome.failures == [] and outcome.pairs == 20
        assert len(outcome.ratios) == 20 and outcome.ratios.min() > 0.9


def test_every_planner_is_measured(world):
    figures = plans.plans(world, 1)
    assert len(figures) == 3 * len(plans.PLANNERS) and all(f.value > 0 for f in figures)
    lengths = [float(f.name.split()[-2]) for f in figures if "plan of" in f.name]
    assert max(lengths) < 1.2 * min(lengths)


def test_updates_give_what_new_fields_have(world):
    figures = updates.updates(world, 1)  # raises where it is something else
    assert len(figures) == 3 and all(figure.peer == "whole field" for figure in figures)


def test_all_parts_give_figures(tmp_path):
    command = [str(SCRIPT), "--faces", "6000", "--repeats", "1", "--goals", "1", "--json"]
    output = subprocess.run(
        command + [str(tmp_path / "f.json")], check=True, stdout=subprocess.PIPE
    ).stdout.decode()
    found = json.loads((tmp_path / "f.json").read_text())
    names = " ".join(figure["name"] for figure in found)
    for name in ("whole field", "to 17 m", "directions", "exact geodesic", "anew", "noise 50 mm"):
        assert name in names
    assert all(figure["value"] >= 0 for figure in found)
    assert "growth" in output
