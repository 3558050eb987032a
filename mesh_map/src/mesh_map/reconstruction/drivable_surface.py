"""A surface as it comes out of a field, made one that a robot can drive on."""

from typing import Any, Dict, List, NamedTuple, Optional, Tuple

from mesh_msgs_hdf5.model.carried_mesh import carried_mesh
from mesh_msgs_hdf5.model.mesh import Mesh

from mesh_map.base.cancel import CancelFlag
from mesh_map.geometry.manifold import make_manifold
from mesh_map.geometry.simplification import simplify
from mesh_map.geometry.topology import quantity
from mesh_map.reconstruction.options import SurfaceOptions
from mesh_map.reconstruction.rim_trimming import trim_rim
from mesh_map.reconstruction.surface_closing import (
    ClosedSurface,
    closed_surface,
    raise_if_canceled,
    without_small_pieces,
)


class SurfaceChanges(NamedTuple):
    """What was done to a surface.

    raw_faces: before.
    mended: what make_manifold() says; "" for nothing.
    dropped_faces: in small components.
    trimmed_faces: at rims that curled.
    holes, hole_faces: closed, and by how many faces.
    shadows, shadow_faces: closed, and by how many faces.
    simplified_from: faces before; 0: it was not simplified.
    """

    raw_faces: int
    mended: str
    dropped_faces: int
    trimmed_faces: int
    holes: int
    hole_faces: int
    shadows: int
    shadow_faces: int
    simplified_from: int

    def lines(self) -> List[str]:
        """For people."""
        lines = ["made manifold: " + self.mended] if self.mended else []
        if self.dropped_faces:
            lines.append("%s in small pieces dropped" % quantity(self.dropped_faces, "faces"))
        if self.trimmed_faces:
            lines.append("%s of curled rims taken away" % quantity(self.trimmed_faces, "faces"))
        for name, count, faces in (
            ("holes", self.holes, self.hole_faces),
            ("shadows", self.shadows, self.shadow_faces),
        ):
            if count:
                lines.append("%s closed by %s" % (quantity(count, name), quantity(faces, "faces")))
        if self.simplified_from:
            lines.append("simplified from %s" % quantity(self.simplified_from, "faces"))
        return lines

    def counts(self) -> Dict[str, Any]:
        """What json can write: those that are not 0."""
        return {name: value for name, value in self._asdict().items() if value}


def drivable(
    mesh: Mesh, options: SurfaceOptions, cancel: Optional[CancelFlag] = None
) -> Tuple[Mesh, SurfaceChanges]:
    """A mesh without non-manifold edges, small pieces, curled rims, small holes and shadows, and
    with fewer faces.

    Faces are turned as they were. What vertices have is carried over.

    Args:
        mesh: of a field; faces show their front to the sensors.
        options: see there.
        cancel: ends it.
    Raises:
        MeshMapError: it has no faces that can be used, or mesh_map was built without
            meshoptimizer, which simplifies.
        Canceled: by `cancel`.
    """
    raw = before = len(mesh.faces)
    trimmed = trim_rim(mesh.vertices, mesh.faces)
    mesh = mesh if trimmed is None else carried_mesh(mesh, trimmed)
    trimmed_faces, before = before - len(mesh.faces), len(mesh.faces)
    raise_if_canceled(cancel)

    # What hangs on the rest by a vertex alone is a small piece, too. Vertices are copied last: in
    # one where two holes touch, their loops would else be one that crosses itself.
    mesh = without_small_pieces(mesh, options)
    dropped = before - len(mesh.faces)
    raise_if_canceled(cancel)

    closed = ClosedSurface(mesh)
    if options.fill_holes > 0:
        closed = closed_surface(mesh, options, cancel)
        mesh = closed.mesh

    manifold = make_manifold(mesh.vertices, mesh.faces, orient=False)
    mesh = mesh if manifold.derived is None else carried_mesh(mesh, manifold.derived)
    mended = "" if manifold.derived is None else manifold.report()
    raise_if_canceled(cancel)

    simplified_from = 0
    if options.simplify > 0:
        simpler = simplify(mesh.vertices, mesh.faces, max_error=options.simplify).derived
        simplified_from = 0 if simpler is None else len(mesh.faces)
        mesh = mesh if simpler is None else carried_mesh(mesh, simpler)
    raise_if_canceled(cancel)
    counts = closed.holes, closed.hole_faces, closed.shadows, closed.shadow_faces
    return mesh, SurfaceChanges(raw, mended, dropped, trimmed_faces, *counts, simplified_from)
