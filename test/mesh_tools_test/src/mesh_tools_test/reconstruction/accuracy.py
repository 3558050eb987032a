"""How near a reconstructed surface comes to the true one, and how sound it is."""

from typing import List

from mesh_map.geometry.border_loops import border_loops

from mesh_tools_test.base.figures import Figure, timed
from mesh_tools_test.reconstruction.scene import BEYOND, VOXEL, Scene, drivable_mesh

MEAN, P95 = 10.0, 25.0  # mm
MISSING = 2.5  # % of what rays reached
MORE_LOOPS = 10  # than the truth has
OUTSIDE = 1.0  # % of the faces
SMALL = 1.0  # m around: such holes in the ground are closed


def measure(scene: Scene, repeats: int) -> List[Figure]:
    """The mesh that the usual options make, beside the surface as it comes out of the field."""
    surface = scene.surface
    making, _ = timed(lambda: drivable_mesh(surface), repeats)
    raw = scene.measured(surface.vertices, surface.faces)
    made = scene.quality
    names = ("accuracy, voxel %.2f m: mean" % VOXEL, "  95 %", "  farthest")
    shares = (BEYOND, "shown from behind")
    peer = "as extracted"
    ours, theirs = made.comparison, raw.comparison
    figures = [
        Figure(
            names[0], 1e3 * ours.accuracy.mean, "mm", peer, 1e3 * theirs.accuracy.mean, floor=MEAN
        ),
        Figure(names[1], 1e3 * ours.accuracy.p95, "mm", peer, 1e3 * theirs.accuracy.p95, floor=P95),
        Figure(names[2], 1e3 * ours.accuracy.max, "mm", peer, 1e3 * theirs.accuracy.max),
        Figure(shares[0], made.missing, "%", peer, raw.missing, floor=MISSING),
        Figure(shares[1], 100 * ours.share_flipped, "%", peer, 100 * theirs.share_flipped),
    ]
    mesh, extracted, truth = ours.mesh, theirs.mesh, ours.truth
    counts = (
        ("border loops", "border_loops", float(truth.border_loops + MORE_LOOPS)),
        ("  border edges in none", "open_border_edges", None),
        ("non-manifold edges", "non_manifold_edges", 0.0),
        ("components", "components", None),
        ("faces", "faces", None),
    )
    for name, member, floor in counts:
        value, before = (float(getattr(each, member)) for each in (mesh, extracted))
        figures.append(Figure(name, value, "", peer, before, floor))
        if member == "border_loops":
            figures.append(Figure("  of the truth", truth.border_loops, ""))
            small, before = (
                float((border_loops(faces, len(points)).perimeters(points) < SMALL).sum())
                for points, faces in (
                    (scene.mesh.vertices, scene.mesh.faces),
                    (surface.vertices, surface.faces),
                )
            )
            name = "  under %g m around" % SMALL
            figures.append(Figure(name, small, "", peer, before))
    outside, before = (100 * each.share_outside_largest for each in (mesh, extracted))
    name = "faces outside the largest component"
    figures.append(Figure(name, outside, "%", peer, before, floor=OUTSIDE))
    figures.append(Figure("surface made drivable", making / 1000.0, "s"))
    return figures
