"""What the parameters of a reconstruction do: one picture for each."""
from pathlib import Path
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.topology import Topology
from mesh_map.reconstruction.options import FieldOptions, SurfaceOptions
from mesh_map.reconstruction.pipeline import Reconstruction
from mesh_map.scans.lidar import LidarModel
from mesh_map.scans.recording import record_scans
from mesh_map.scans.scan import Scan
from mesh_msgs.world.solids import Part, box, floor, joined

from mesh_tools_test.tutorials.panels import (
    BLUE,
    ORANGE,
    THING,
    Panels,
    area_key,
    dot_key,
    draw_boxes,
    draw_path,
    line_key,
)
from mesh_tools_test.tutorials.parameter_worlds import Rectangle, Thing

CURB = Thing(1.0, 1.8, 0.0, 0.1)
STEP = Thing(2.8, 3.8, 0.0, 0.25)
BOARD = Thing(5.2, 5.25, 0.0, 0.7)
GAP = Thing(6.6, 7.1, 0.0, 0.5), Thing(7.25, 7.75, 0.0, 0.5)
THINGS = (CURB, STEP, BOARD, *GAP)
PERSON = Thing(4.4, 4.7, 0.0, 1.1)
"""Who was there for a moment."""
_NAMES = (
    (1.4, 0.1, "curb 0.1 m"),
    (3.3, 0.25, "step 0.25 m"),
    (5.5, 0.7, "board, 5 cm thick"),
    (7.17, 0.5, "gap of 0.15 m"),
)
_TRACK, _HALF = (0.0, 9.0), 3.0  # m: along, and to either side
_BELOW, _ABOVE = 0.2, 1.4  # m that is drawn
_SENSOR = 0.9  # m above the ground

SITE = (12.0, 8.0)  # m
PILLARS: List[Rectangle] = [(2.0, 4.6, 2.5, 5.1), (5.6, 5.4, 6.4, 5.8), (9.0, 4.4, 9.2, 4.6)]
_SITE_SCANS = ((2.0, 2.0), (5.0, 2.4), (8.0, 2.0), (10.5, 2.4))
_NOISE = 0.01  # m
GROUND = (0.78, 0.78, 0.78)


class Surface(NamedTuple):
    """vertices: (V, 3) float32 m; faces: (F, 3)."""

    vertices: np.ndarray
    faces: np.ndarray


def all_pictures(folder: Path) -> None:
    """Write them into a folder."""
    track = scans_of_track()
    default = surface_of(field_of(track))
    voxels = {0.05: surface_of(field_of(track, voxel_size=0.05)), 0.1: default}
    voxels[0.2] = surface_of(field_of(track, voxel_size=0.2))
    _sections(
        folder / "voxel_size.png",
        [(f"voxel_size {value:g} m", surface) for value, surface in voxels.items()],
    )
    bands = {0.1: surface_of(field_of(track, truncation=0.1)), 0.2: default}
    bands[0.5] = surface_of(field_of(track, truncation=0.5))
    _sections(
        folder / "truncation.png",
        [(f"truncation {value:g} m", surface) for value, surface in bands.items()],
    )
    visited = scans_of_track(PERSON)
    _sections(
        folder / "carve.png",
        [
            (title, surface_of(field_of(visited, carve=carve), min_component=0))
            for title, carve in (("without carve", False), ("with carve", True))
        ],
        PERSON,
    )
    site = scans_of_site()
    _from_above(
        folder / "max_range.png",
        [
            (f"max_range {value:g} m", surface_of(field_of(site, max_range=value)))
            for value in (3.0, 5.0, 8.0)
        ],
    )
    field = field_of(site)
    _from_above(
        folder / "fill_holes.png",
        [
            (f"fill_holes {value:g} m", surface_of(field, fill_holes=value, fill_shadows=0))
            for value in (0, 1, 4)
        ],
    )
    _from_above(
        folder / "fill_shadows.png",
        [
            (f"fill_shadows {value:g} m", surface_of(field, fill_shadows=value))
            for value in (0, 0.2, 1)
        ],
    )
    _from_above(
        folder / "min_component.png",
        [
            (f"min_component {value}", surface_of(field, min_component=value))
            for value in (0, 50, 500)
        ],
    )


def scans_of_track(person: Optional[Thing] = None) -> List[Scan]:
    """Of a lidar that goes past THINGS on both sides, between two walls: 20 scans.

    :param person: if one is there during a first scan, before 60 others
    """
    places = [(x, side) for side in (-1.3, 1.3) for x in np.arange(*_TRACK, 0.9)]
    if person is None:
        return _scans(_track_part(), places, 0, 384)
    scans = _scans(_track_part(person), [(3.6, -1.3)], 0, 256)
    return scans + _scans(_track_part(), 3 * places, 1, 256)


def _track_part(person: Optional[Thing] = None) -> Part:
    parts = [floor((_TRACK[0], -_HALF), (_TRACK[1], _HALF), 0.5)]
    for y in (-_HALF, _HALF - 0.2):
        parts.append(box((_TRACK[0], y, 0.0), (_TRACK[1], y + 0.2, 3.0)))
    for each in THINGS:
        parts.append(box((each.begin, -0.8, each.low), (each.end, 0.8, each.high)))
    if person is not None:
        parts.append(box((person.begin, -0.15, person.low), (person.end, 0.15, person.high)))
    return joined(*parts)


def scans_of_site() -> List[Scan]:
    """Of a lidar that stops at four places of SITE, before PILLARS."""
    pillars = [box((a, b, 0.0), (c, d, 1.5)) for a, b, c, d in PILLARS]
    return _scans(joined(floor((0.0, 0.0), SITE, 0.5), *pillars), _SITE_SCANS, 0, 512)


def _scans(
    part: Part, places: Sequence[Tuple[float, float]], seed: int, columns: int
) -> List[Scan]:
    geometry = MeshGeometry(part[0].astype(np.float32), part[1].astype(np.uint32))
    poses = np.tile(np.eye(4), (len(places), 1, 1))
    poses[:, :2, 3], poses[:, 2, 3] = places, _SENSOR
    lidar = LidarModel(rings=48, columns=columns, lowest=-0.9, highest=0.2, noise=_NOISE)
    return [each.scan for each in record_scans(geometry, poses, lidar=lidar, seed=seed)]


def field_of(scans: Sequence[Scan], **options: Any) -> Reconstruction:
    """All scans, with these FieldOptions."""
    made = Reconstruction(FieldOptions(**options))
    for scan in scans:
        made.add(scan)
    return made


def surface_of(field: Reconstruction, **options: Any) -> Surface:
    """With these SurfaceOptions."""
    mesh, _ = field.surface(SurfaceOptions(**options))
    return Surface(mesh.vertices, mesh.faces)


def section(surface: Surface) -> np.ndarray:
    """(K, 2, 2) m: x and z of the ends of the segments in which the plane y = 0 cuts faces."""
    corners = surface.vertices[surface.faces].astype(np.float64)
    ahead = corners[:, :, 1] >= 0
    cut = ahead.any(axis=1) & ~ahead.all(axis=1)
    corners, ahead = corners[cut], ahead[cut]
    following, other = np.roll(corners, -1, axis=1), np.roll(ahead, -1, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = corners[:, :, 1] / (corners[:, :, 1] - following[:, :, 1])
        points = corners + share[:, :, None] * (following - corners)
    return points[ahead != other].reshape(-1, 2, 3)[:, :, [0, 2]]


def parts_of(surface: Surface) -> np.ndarray:
    """(F,) bool: faces that are not in the largest component."""
    topology = Topology(faces=surface.faces, vertex_count=len(surface.vertices))
    component = topology.components[surface.faces[:, 0]]
    return component != np.bincount(component).argmax()


def _sections(
    path: Path, shown: Sequence[Tuple[str, Surface]], person: Optional[Thing] = None
) -> None:
    size = _TRACK[1] - _TRACK[0], _BELOW + _ABOVE
    panels = Panels([title for title, _ in shown], size, stacked=True)
    for axes, (_, surface) in zip(panels.axes, shown):
        axes.axhspan(-_BELOW, 0.0, color=THING, lw=0)
        draw_boxes(axes, [(each.begin, each.low, each.end, each.high) for each in THINGS])
        axes.add_collection(LineCollection(section(surface), colors=[ORANGE], lw=2.2, zorder=5))
        if person is not None:
            x, z = (person.begin, person.end), (person.low, person.high)
            outline = np.array([[x[0], z[0]], [x[0], z[1]], [x[1], z[1]], [x[1], z[0]]])
            draw_path(axes, outline, BLUE, "--")
        axes.set_xlim(*_TRACK)
        axes.set_ylim(-_BELOW, _ABOVE)
    for x, z, text in _NAMES:
        panels.axes[0].annotate(text, (x, z + 0.08), fontsize=8, ha="center", va="bottom")
    panels.name_axes("x [m]", "z [m]")
    handles = [area_key(THING, "what is there"), line_key(ORANGE, "what is reconstructed")]
    if person is not None:
        handles.append(line_key(BLUE, "where a person was during 1 of 61 scans", "--"))
    panels.key(handles)
    panels.save(path)


def _from_above(path: Path, shown: Sequence[Tuple[str, Surface]]) -> None:
    panels = Panels([title for title, _ in shown], SITE)
    some_apart = False
    for axes, (_, surface) in zip(panels.axes, shown):
        corners = surface.vertices[surface.faces]
        order = np.argsort(corners[:, :, 2].max(axis=1), kind="stable")
        apart = parts_of(surface)[order]
        colors = np.where(apart[:, None], ORANGE, GROUND)
        faces = PolyCollection(corners[order, :, :2], facecolors=colors, edgecolors=colors, lw=0.3)
        axes.add_collection(faces)
        draw_boxes(axes, PILLARS)
        axes.plot(*np.transpose(_SITE_SCANS), "o", color=BLUE, markersize=5, zorder=6)
        axes.set_xlim(0.0, SITE[0])
        axes.set_ylim(0.0, SITE[1])
        some_apart |= bool(apart.any())
    panels.name_axes("x [m]", "y [m]")
    handles = [area_key(GROUND, "the ground that is reconstructed")]
    if some_apart:
        handles.append(area_key(ORANGE, "pieces that nothing connects with it"))
    handles += [area_key(THING, "pillars"), dot_key(BLUE, "where scans were made")]
    panels.key(handles)
    panels.save(path)
