"""What the page of scans says of its pictures is to be seen in them."""
import numpy as np
import pytest
from mesh_map.geometry.border_loops import border_loops

from mesh_tools_test.tutorials.reconstruction_pictures import (
    BOARD,
    PERSON,
    STEP,
    Surface,
    field_of,
    parts_of,
    scans_of_site,
    scans_of_track,
    section,
    surface_of,
)


@pytest.fixture(scope="module")
def track():
    return scans_of_track()


@pytest.fixture(scope="module")
def site():
    return field_of(scans_of_site())


def thickness(surface, height=0.4):
    """m: of what stands there for the board, in the section."""
    ends = section(surface)
    low, high = ends[:, :, 1].min(axis=1), ends[:, :, 1].max(axis=1)
    x = ends[(low <= height) & (high >= height)].mean(axis=1)[:, 0]
    near = x[np.abs(x - (BOARD.begin + BOARD.end) / 2) < 0.6]
    return near.max() - near.min()


def test_a_section_is_where_the_plane_cuts_faces():
    vertices = np.float32([[0, -1, 0], [2, -1, 0], [1, 1, 2], [5, -2, 0], [6, -2, 0], [5, -1, 0]])
    found = section(Surface(vertices, np.uint32([[0, 1, 2], [3, 4, 5]])))
    assert np.sort(found, axis=1) == pytest.approx(np.array([[[0.5, 1.0], [1.5, 1.0]]]))


def test_thin_things_are_drawn_thicker_by_voxels_and_by_the_truncation(track):
    by_voxel = [thickness(surface_of(field_of(track, voxel_size=v))) for v in (0.05, 0.1, 0.2)]
    assert BOARD.end - BOARD.begin < by_voxel[0] + 0.02 < by_voxel[1] < by_voxel[2]
    by_truncation = [thickness(surface_of(field_of(track, truncation=t))) for t in (0.1, 0.2, 0.5)]
    assert by_truncation[0] < by_truncation[1] < by_truncation[2]


def test_steps_keep_their_height(track):
    ends = section(surface_of(field_of(track))).reshape(-1, 2)
    on_step = (ends[:, 0] > STEP.begin + 0.2) & (ends[:, 0] < STEP.end - 0.2)
    assert np.abs(ends[on_step, 1] - STEP.high).max() < 0.03


def test_rays_take_away_a_person_who_went_by():
    scans = scans_of_track(PERSON)
    left = []
    for carve in (False, True):
        x, z = section(surface_of(field_of(scans, carve=carve), min_component=0)).reshape(-1, 2).T
        left.append(np.count_nonzero((np.abs(x - 4.55) < 0.3) & (z > 0.15)))
    assert left[0] > 10
    assert left[1] == 0


def test_a_range_bounds_the_ground(site):
    highest = [
        surface_of(field_of(scans_of_site(), max_range=value)).vertices[:, 1].max()
        for value in (3.0, 5.0)
    ]
    assert highest[0] < 5.4 < highest[1]
    assert highest[1] < surface_of(site).vertices[:, 1].max()


def test_holes_are_closed_up_to_their_size_and_pieces_dropped_by_faces(site):
    def loops_of(**options):
        surface = surface_of(site, **options)
        return border_loops(surface.faces, len(surface.vertices)).count

    loops = [loops_of(fill_holes=value, fill_shadows=0) for value in (0, 1, 4)]
    assert loops[0] > loops[1] > loops[2]
    loops = [loops_of(fill_shadows=value) for value in (0, 0.2, 1)]
    assert loops[0] > loops[1] > loops[2]
    apart = [int(parts_of(surface_of(site, min_component=value)).sum()) for value in (0, 50, 500)]
    assert apart[0] > apart[1] > apart[2] == 0
