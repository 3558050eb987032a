"""The screened Poisson reconstruction of Open3D, where it is installed (python3-open3d)."""

import math
import time
from typing import Any, List, NamedTuple, Optional

import numpy as np

from mesh_tools_test.base.figures import Figure
from mesh_tools_test.reconstruction.scene import BEYOND, VOXEL, Quality, Scene, drivable_mesh

NEIGHBORHOOD, NEIGHBORS = 0.3, 30  # m and at most so many, of which a normal is estimated
TRIMMED = 0.05  # of the vertices: those with the fewest points around
_SCALE = 1.1  # of the cube around the points, as Open3D has it


class PoissonSurface(NamedTuple):
    """quality: of all of it; trimmed: of the part with points around; seconds: with normals."""

    quality: Quality
    trimmed: Quality
    seconds: float


def measure(scene: Scene) -> List[Figure]:
    """Ours beside Poisson with cells of the size of the voxels, each once; no figures without
    Open3D."""
    poisson = poisson_surface(scene)
    if poisson is None:
        return []
    begin = time.perf_counter()
    drivable_mesh(scene.field(VOXEL).extract())
    ours = (time.perf_counter() - begin) / scene.points
    theirs = poisson.seconds / scene.points
    figures = [Figure("points to a mesh", ours, "s/M", "Poisson", theirs)]
    accuracy = scene.quality.comparison.accuracy
    for peer, quality in (
        ("Poisson", poisson.quality),
        ("Poisson, %g %% trimmed" % (100 * TRIMMED), poisson.trimmed),
    ):
        other = quality.comparison
        figures += [
            Figure("accuracy: mean", 1e3 * accuracy.mean, "mm", peer, 1e3 * other.accuracy.mean),
            Figure("  95 %", 1e3 * accuracy.p95, "mm", peer, 1e3 * other.accuracy.p95),
            Figure(
                "  " + BEYOND,
                scene.quality.missing,
                "%",
                peer,
                quality.missing,
            ),
        ]
    return figures


def poisson_surface(scene: Scene, cell: float = VOXEL) -> Optional[PoissonSurface]:
    """Of all points of a scene, with cells of at most so many m; None without Open3D."""
    try:
        import open3d
    except ImportError:
        return None
    points = np.concatenate([scan.in_map() for scan in scene.scans]).astype(np.float64)
    counts = [len(scan.points) for scan in scene.scans]
    sensors = np.repeat([scan.origins_in_map() for scan in scene.scans], counts, axis=0)
    begin = time.perf_counter()
    cloud: Any = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    cloud.estimate_normals(open3d.geometry.KDTreeSearchParamHybrid(NEIGHBORHOOD, NEIGHBORS))
    normals = np.asarray(cloud.normals)
    away = np.einsum("ni,ni->n", normals, sensors - points) < 0
    normals[away] *= -1.0
    size = _SCALE * float(np.ptp(points, axis=0).max())
    depth = max(1, math.ceil(math.log2(size / cell)))
    make = open3d.geometry.TriangleMesh.create_from_point_cloud_poisson
    mesh, densities = make(cloud, depth=depth, scale=_SCALE)
    seconds = time.perf_counter() - begin
    vertices = np.asarray(mesh.vertices, np.float32)
    faces = np.asarray(mesh.triangles).astype(np.uint32)
    dense = np.asarray(densities) >= np.quantile(np.asarray(densities), TRIMMED)
    kept = faces[dense[faces].all(axis=1)]
    return PoissonSurface(scene.measured(vertices, faces), scene.measured(vertices, kept), seconds)
