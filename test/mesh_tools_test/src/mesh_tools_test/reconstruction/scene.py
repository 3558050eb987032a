"""What is reconstructed in the benchmark: scans of a world whose true surface is known."""

from dataclasses import replace
from functools import cached_property
from typing import List, NamedTuple

import numpy as np
from mesh_map.geometry.mesh_comparison import Distances, MeshComparison, compare_meshes
from mesh_map.reconstruction.drivable_surface import drivable
from mesh_map.reconstruction.options import SurfaceOptions
from mesh_map.reconstruction.signed_distance import FieldSurface, SignedDistanceField
from mesh_map.scans.scan import Scan
from mesh_map.spatial.spatial_index import SpatialIndex
from mesh_msgs_hdf5.model.mesh import Mesh

from mesh_tools_test.base.scanned_world import FACES, LIDAR, SCANS, scanned_world

VOXEL = 0.1  # m
TOLERANCE = 0.05  # m up to which a place is found again, and the side of what counts as a place

BEYOND = "of what rays reached, beyond %g cm" % (100 * TOLERANCE)  # name of a figure


class Quality(NamedTuple):
    """comparison: with the truth; found: distances of the places that rays reached from a mesh."""

    comparison: MeshComparison
    found: Distances

    @property
    def missing(self) -> float:
        """% of the places that rays reached which are not within TOLERANCE of the mesh."""
        return 100.0 * (1.0 - self.found.share_within)


class Scene:
    """Scans of the world along one drive, in memory.

    Args:
        faces: of the world. scans: how many. columns: of the lidar; None: as many as it has.
    Attributes:
        world, lidar: what is scanned, and by what.
        scans: with colors.
        points: M, how many million of them there are.
        is_usual: whether it is that of the figures that are promised.
    """

    def __init__(self, faces: int = FACES, scans: int = SCANS, columns: int = 0) -> None:
        self.world = scanned_world(faces)
        self.lidar = replace(LIDAR, columns=columns or LIDAR.columns)
        self.scans: List[Scan] = [each.scan for each in self.world.scans(self.lidar, scans)]
        self.points = sum(len(scan.points) for scan in self.scans) / 1e6
        self.is_usual = (faces, scans, self.lidar) == (FACES, SCANS, LIDAR)

    @cached_property
    def reached(self) -> np.ndarray:
        """(N, 3) float32 m: where rays without noise end, one in each cell of TOLERANCE."""
        exact = self.world.scans(replace(self.lidar, noise=0.0), len(self.scans))
        return one_of_each_cell(np.concatenate([each.scan.in_map() for each in exact]), TOLERANCE)

    def field(self, voxel_size: float, threads: int = 0) -> SignedDistanceField:
        """All scans, brought into the frame of the map, in a new field with colors; threads: 0 for
        all cores."""
        field = SignedDistanceField(voxel_size=voxel_size, colors=True, threads=threads)
        for scan in self.scans:
            field.integrate(scan.in_map(), scan.origins_in_map(), colors=scan.colors)
        return field

    @cached_property
    def surface(self) -> FieldSurface:
        """Of voxels of VOXEL, as it comes out of the field."""
        return self.field(VOXEL).extract()

    @cached_property
    def mesh(self) -> Mesh:
        """What the usual options make of the surface, to be driven on."""
        return drivable_mesh(self.surface)

    @cached_property
    def quality(self) -> Quality:
        """Of the mesh."""
        return self.measured(self.mesh.vertices, self.mesh.faces)

    def measured(self, vertices: np.ndarray, faces: np.ndarray) -> Quality:
        """Of a mesh, (V, 3) m and (F, 3)."""
        truth = self.world.mesh
        comparison = compare_meshes(
            truth.vertices, truth.faces, vertices, faces, tolerance=TOLERANCE
        )
        index = SpatialIndex(vertices, faces)
        away = index.closest_batch(points=self.reached, back_end="native").distances
        found = Distances(
            len(away),
            float(away.mean()),
            float(np.percentile(away, 95)),
            float(away.max()),
            float((away <= TOLERANCE).mean()),
        )
        return Quality(comparison, found)


def drivable_mesh(surface: FieldSurface) -> Mesh:
    """As the command makes it, with the usual options."""
    mesh = Mesh(
        vertices=surface.vertices,
        faces=surface.faces,
        vertex_normals=surface.normals,
        vertex_colors=surface.colors,
    )
    return drivable(mesh, SurfaceOptions())[0]


def one_of_each_cell(points: np.ndarray, size: float) -> np.ndarray:
    """The first of the points (N, 3) in each cell of a side of `size` (m), in their order."""
    cells = np.floor(points / size).astype(np.int64)
    cells -= cells.min(axis=0)
    numbers = np.ravel_multi_index(tuple(cells.T), tuple(cells.max(axis=0) + 1))
    return points[np.sort(np.unique(numbers, return_index=True)[1])]
