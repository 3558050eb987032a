"""The benchmark of the spatial index measures what it says, and its peers agree with the index."""
import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from mesh_map.spatial.spatial_index import SpatialIndex
from mesh_tools_test.base.exact_world import exact_world
from mesh_tools_test.base.figures import Figure, million_per_second, table, timed
from mesh_tools_test.spatial import opencl, questions

SCRIPT = Path(__file__).resolve().parents[2] / "benchmark/spatial_index.py"


@pytest.fixture(scope="module")
def world():
    return exact_world(20_000)


def test_figures_know_which_is_better():
    assert Figure("a", 2.0, "ms", "b", 3.0).ratio == pytest.approx(1.5)
    assert Figure("a", 2.0, "Mray/s", "b", 3.0).ratio == pytest.approx(2.0 / 3.0)
    assert Figure("a", 2.0, "ms", "b", None).ratio is None
    assert Figure("a", 2.0, "ms", floor=2.0).keeps_floor
    assert not Figure("a", 2.1, "ms", floor=2.0).keeps_floor
    assert Figure("a", 5.0, "Mray/s", floor=5.0).keeps_floor
    assert not Figure("a", 4.9, "Mray/s", floor=5.0).keeps_floor
    assert million_per_second(2_000_000, 1000.0) == pytest.approx(2.0)
    text = table([Figure("slow", 2.0, "ms", "peer", 4.0, 1.0), Figure("fast", 0.5, "ms", floor=1)])
    assert "2.00 x peer" in text and text.count("MISSED") == 1 and "slow" in text.splitlines()[1]
    assert timed(lambda: 7, 3)[1] == 7


def test_pixels_of_the_picture_lie_within_its_planes(world):
    view = questions.side_camera(world[0])
    for columns, rows in ((1, 1), (5, 3)):
        directions = view.directions(columns, rows)
        assert directions.shape == (columns * rows, 3)
        points = np.column_stack([view.eye + 5.0 * directions, np.ones(len(directions))])
        assert (points @ view.planes(1.0, 1.0).T > 0.0).all()
    # the first pixel is at the top left, the last at the bottom right
    directions = view.directions(*questions.PICTURE)
    clip = np.column_stack([view.eye + directions[[0, -1]], [1, 1]]) @ view.view_projection.T
    expected = 1.0 - 1.0 / np.array(questions.PICTURE)
    np.testing.assert_allclose(clip[0, :2] / clip[0, 3], expected * [-1, 1], atol=1e-9)
    np.testing.assert_allclose(clip[1, :2] / clip[1, 3], expected * [1, -1], atol=1e-9)


def test_a_rectangle_touches_as_many_faces_as_asked_for(world):
    index = SpatialIndex(*world)
    view = questions.top_camera(world[0])
    planes, touched = questions.rectangle_of(view, 3000, lambda p: index.in_frustum(planes=p))
    assert len(index.in_frustum(planes=planes)) == touched
    assert abs(touched - 3000) <= 30
    assert len(index.in_frustum(planes=view.planes(1.0, 1.0))) == len(world[1])


@pytest.mark.skipif(opencl.device_name() is None, reason="no OpenCL device")
def test_the_linear_scan_finds_what_the_index_finds(world):
    from mesh_tools_test.spatial.linear_scan import LinearScan

    vertices, faces = world
    index, scan = SpatialIndex(vertices, faces), LinearScan(vertices, faces, opencl.device())
    rays = questions.coherent_rays(vertices)[::50_001].astype(np.float64)
    hits = [index.cast(origin=ray[:3], direction=ray[3:]) for ray in rays]
    assert 5 < sum(hit is not None for hit in hits) < len(rays)
    for ray, hit in zip(rays, hits):
        face = scan.cast(ray[:3], ray[3:])
        assert face == (-1 if hit is None else hit.face)
    # the scan finds faces by their corners alone
    center = questions.points_near(vertices, 1)[0].astype(np.float64)
    near = np.linalg.norm(vertices - center, axis=1) <= 2.0
    assert np.array_equal(scan.in_sphere(center, 2.0), np.flatnonzero(near[faces].any(axis=1)))
    assert np.isin(scan.in_sphere(center, 2.0), index.in_sphere(center=center, radius=2.0)).all()
    planes = questions.top_camera(vertices).planes(0.2, 0.3)
    inside = (np.column_stack([vertices, np.ones(len(vertices))]) @ planes.T >= 0.0).all(axis=1)
    assert np.array_equal(scan.in_planes(planes), np.flatnonzero(inside[faces].any(axis=1)))


def test_the_benchmark_runs_and_agrees_with_its_peers(tmp_path):
    """On a small mesh; it ends with an error where Embree answers otherwise."""
    result = tmp_path / "figures.json"
    command = [str(SCRIPT), "--faces", "20000", "--repeats", "1", "--json", str(result)]
    command += ["--only", "native", "selections", "opencl"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=120)
    assert done.returncode == 0, done.stderr.decode()
    names = {row["name"] for row in json.loads(result.read_text())}
    assert {"pick, Python", "closest point, Python"} <= names
    assert b"20,000 faces" in done.stdout
