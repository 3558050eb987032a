"""A surface as it comes out of a field, made one that a robot can drive on."""

from typing import Any, Dict, List, NamedTuple, Optional, Tuple

import numpy as np
from mesh_msgs_hdf5.model.carried_mesh import carried_mesh
from mesh_msgs_hdf5.model.mesh import Mesh

from mesh_map.base.cancel import CancelFlag
from mesh_map.base.errors import Canceled
from mesh_map.geometry.components import drop_components
from mesh_map.geometry.hole_filling import fill_holes
from mesh_map.geometry.manifold import make_manifold
from mesh_map.geometry.simplification import simplify
from mesh_map.geometry.topology import quantity
from mesh_map.reconstruction.options import SurfaceOptions


class SurfaceChanges(NamedTuple):
    """What was done to a surface.

    raw_faces: before.
    mended: what make_manifold() says; "" for nothing.
    dropped_faces: in small components.
    holes, hole_faces: closed, and by how many faces.
    simplified_from: faces before; 0: it was not simplified.
    """

    raw_faces: int
    mended: str
    dropped_faces: int
    holes: int
    hole_faces: int
    simplified_from: int

    def lines(self) -> List[str]:
        """For people."""
        lines = ["made manifold: " + self.mended] if self.mended else []
        if self.dropped_faces:
            lines.append("%s in small pieces dropped" % quantity(self.dropped_faces, "faces"))
        if self.holes:
            text = "%s closed by %s"
            lines.append(text % (quantity(self.holes, "holes"), quantity(self.hole_faces, "faces")))
        if self.simplified_from:
            lines.append("simplified from %s" % quantity(self.simplified_from, "faces"))
        return lines

    def counts(self) -> Dict[str, Any]:
        """What json can write: those that are not 0."""
        return {name: value for name, value in self._asdict().items() if value}


def drivable(
    mesh: Mesh, options: SurfaceOptions, cancel: Optional[CancelFlag] = None
) -> Tuple[Mesh, SurfaceChanges]:
    """A mesh without non-manifold edges, small pieces and small holes, and with fewer faces.

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
    # What hangs on the rest by a vertex alone is a small piece, too. Vertices are copied last: in
    # one where two holes touch, their loops would else be one that crosses itself.
    large = drop_components(
        mesh.vertices, mesh.faces, min_faces=options.min_component, across_vertices=False
    )
    mesh = mesh if large is None else carried_mesh(mesh, large)
    dropped = before - len(mesh.faces)
    _look(cancel)

    holes = hole_faces = 0
    if options.fill_holes > 0:
        filled = fill_holes(mesh.vertices, mesh.faces, max_perimeter=options.fill_holes)
        holes, hole_faces = filled.counts()["filled"], int(np.count_nonzero(filled.new_faces))
        mesh = mesh if filled.derived is None else carried_mesh(mesh, filled.derived)
    _look(cancel)

    manifold = make_manifold(mesh.vertices, mesh.faces, orient=False)
    mesh = mesh if manifold.derived is None else carried_mesh(mesh, manifold.derived)
    mended = "" if manifold.derived is None else manifold.report()
    _look(cancel)

    simplified_from = 0
    if options.simplify > 0:
        simpler = simplify(mesh.vertices, mesh.faces, max_error=options.simplify).derived
        simplified_from = 0 if simpler is None else len(mesh.faces)
        mesh = mesh if simpler is None else carried_mesh(mesh, simpler)
    _look(cancel)
    return mesh, SurfaceChanges(raw, mended, dropped, holes, hole_faces, simplified_from)


def _look(cancel: Optional[CancelFlag]) -> None:
    if cancel is not None and cancel.is_set():
        raise Canceled("the surface was not made")
