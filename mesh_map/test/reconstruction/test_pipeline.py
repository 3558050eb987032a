"""Scans to a drivable surface: options, channels, origin, jumps, and going on."""

from dataclasses import replace

import numpy as np
import pytest
from scan_bags import drive

from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled, MeshMapError
from mesh_map.geometry.topology import Topology
from mesh_map.reconstruction import pipeline
from mesh_map.reconstruction.options import FieldOptions, SurfaceOptions
from mesh_map.reconstruction.pipeline import Reconstruction
from mesh_map.reconstruction.pose_jumps import PoseJumps
from mesh_map.reconstruction.signed_distance import FieldMemoryError
from mesh_map.scans.left_out import LeftOutCounts

COARSE = FieldOptions(voxel_size=0.3)
SURFACE = SurfaceOptions(min_component=20)


def made_of(scans, options=COARSE, **keywords):
    made = Reconstruction(options, **keywords)
    for scan in scans:
        made.add(scan)
    return made


def bits(made, options=SURFACE):
    mesh = made.surface(options)[0]
    arrays = (mesh.vertices, mesh.faces, mesh.vertex_normals, mesh.vertex_colors)
    return [array.tobytes() for array in (*arrays, *mesh.vertex_attributes.values())]


def test_threads_and_a_break_change_no_bit():
    whole = made_of(drive(), threads=1)
    half = made_of(drive()[:4], threads=2)
    half.surface(SURFACE)
    values, data = half.stored()
    rest = Reconstruction.restored(values, data)
    for scan in drive()[4:]:
        rest.add(scan)
    assert bits(rest) == bits(whole) and (rest.scans, rest.points) == (8, whole.points)
    with pytest.raises(MeshMapError, match="damaged"):
        Reconstruction.restored(values, data[:-100])
    with pytest.raises(MeshMapError, match="damaged"):
        Reconstruction.restored({}, data)


def test_no_point_counts_twice_after_the_memory_limit(monkeypatch):
    monkeypatch.setattr(pipeline, "BATCH_POINTS", 500)
    whole = made_of(drive()[:4])
    part = Reconstruction(COARSE, memory_limit=int(0.8 * whole.memory))
    done = 0
    with pytest.raises(FieldMemoryError, match="more than its limit"):
        for scan in drive()[:4]:
            part.add(scan)
            done += 1
    rest = Reconstruction.restored(*part.stored())
    for scan in drive()[done:4]:
        rest.add(scan)
    assert 0 < done == part.scans < 4 and rest.points == whole.points
    observed = [
        made.surface(SURFACE)[0].vertex_attributes["observations"] for made in (rest, whole)
    ]
    assert observed[0].mean() == pytest.approx(observed[1].mean(), rel=0.02)
    assert rest.left_out.stored() == whole.left_out.stored()


def test_the_surface_can_be_driven_on():
    made = made_of(drive())
    raw, _ = made.surface(SurfaceOptions(fill_holes=0, min_component=0))
    mesh, changes = made.surface(SurfaceOptions(simplify=0.05, min_component=20))
    topology = Topology(faces=mesh.faces, vertex_count=len(mesh.vertices))
    assert not topology.non_manifold_edges.any()
    assert len(mesh.faces) < 0.8 * len(raw.faces)
    assert changes.counts().keys() >= {"raw_faces", "dropped_faces", "holes", "simplified_from"}
    assert len(changes.lines()) >= 3
    flag = CancelFlag()
    flag.set()
    with pytest.raises(Canceled):
        made.surface(cancel=flag)


def test_channels_are_those_of_the_first_scan():
    bare = [replace(scan, colors=None, intensities=None) for scan in drive()]
    mixed = made_of([drive()[0], bare[1], bare[2]])
    assert mixed.left_out.lines() == [
        "2 scans (first: scan 1) without colors among such with colors",
        "2 scans (first: scan 1) without intensities among such with intensities",
    ]
    assert mixed.surface(SURFACE)[0].vertex_colors is not None
    late = made_of([bare[0], drive()[1]])
    assert "colors of 1 scan (scan 1) are not used" in late.left_out.lines()[0]
    mesh = late.surface(SURFACE)[0]
    assert mesh.vertex_colors is None and list(mesh.vertex_attributes) == ["observations"]


def test_scans_too_far_from_the_origin_are_left_out():
    away = drive()[1].pose.copy()
    away[0, 3] = 1e6
    made = made_of([drive()[0], replace(drive()[1], pose=away)])
    assert made.scans == 1
    assert made.left_out.lines()[0].startswith("left out: 1 scan (scan 1) too far from the map's")


def test_a_share_of_the_points_evenly():
    scan = drive()[0]
    for given, kept in ((4, 504), (0.25, 504), (1.5, 1344), (0.9, 1814)):
        made = made_of([scan], replace(COARSE, decimate=given))
        assert made.points == pytest.approx(kept, abs=1)
        assert made.left_out.count("decimated") == len(scan.points) - made.points


@pytest.mark.parametrize(
    "values, text",
    [
        ({"voxel_size": 0}, "voxel_size is 0"),
        ({"voxel_size": np.nan}, "voxel_size is nan"),
        ({"truncation": 0.01}, "truncation is 0.01"),
        ({"min_range": 5, "max_range": 5}, "no point is between"),
        ({"decimate": 0}, "decimate is 0"),
        ({"origin": (np.inf, 0, 0)}, "is no place"),
    ],
)
def test_options_that_make_no_field(values, text):
    with pytest.raises(MeshMapError, match=text):
        FieldOptions(**values)
    with pytest.raises(MeshMapError):
        SurfaceOptions(fill_holes=-1)
    with pytest.raises(MeshMapError, match="fill_shadows is -1"):
        SurfaceOptions(fill_shadows=-1)


def test_nothing_makes_no_surface():
    with pytest.raises(MeshMapError, match="there is no scan"):
        Reconstruction().surface()
    with pytest.raises(MeshMapError, match="nothing to go on with"):
        Reconstruction().stored()
    thin = replace(drive()[0], points=drive()[0].points[:1], colors=None, intensities=None)
    with pytest.raises(MeshMapError, match="1 points of 1 scans make no surface"):
        made_of([thin]).surface()


def test_jumps_are_fast_or_unlike_those_before():
    def steps(lengths, seconds):
        left_out, place = LeftOutCounts(), 0.0
        jumps = PoseJumps(left_out)
        for i, length in enumerate([0.0, *lengths]):
            place += length
            pose = np.eye(4)
            pose[0, 3] = place
            time = None if seconds is None else i * seconds
            jumps.add(replace(drive()[0], pose=pose, time=time, name="scan %d" % i))
        return left_out.count("jump")

    assert steps([1.0] * 9, 0.1) == 0
    assert steps([0.1, 10.0, 0.1, 0.1], 0.1) == 1  # 100 m/s
    assert steps([2.0] * 5 + [10.0] + [2.0] * 5, 2.0) == 1
    assert steps([20.0, 35.0, 18.0, 40.0, 25.0], None) == 0  # a surveyor's stations
