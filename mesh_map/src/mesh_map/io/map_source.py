"""Where a mesh map comes from, a map file or a mesh file of any format, and what else is in it."""

import json
import logging
import math
import threading
import weakref
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
from mesh_msgs.checks.rounding import is_too_much
from mesh_msgs.derived_mesh import DerivedMesh
from mesh_msgs.identity import geometry_uuid
from mesh_msgs_hdf5.formats.any_mesh import open_members
from mesh_msgs_hdf5.formats.importer import too_much_rounded
from mesh_msgs_hdf5.labels.map_contents import MapContents
from mesh_msgs_hdf5.model.carried_mesh import CARRIED_BY
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.layer_meaning import KEY, computed_with
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.model.seams import split_mesh, without_copies
from mesh_msgs_hdf5.files.save import stamp

from mesh_map.base.array_checks import read_only
from mesh_map.base.digest import digest
from mesh_map.base.errors import PLUGIN_FAILURES, MeshMapError, error_line
from mesh_map.costs.layer import ON_TRUST, Layer
from mesh_map.geometry.coordinates import check_rounding, checked_origin
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.geometry.normals import checked_up, unit_normals
from mesh_map.geometry.refinement import refine
from mesh_map.geometry.seams import refined_split, turned
from mesh_map.io.derived_contents import DerivedContents, WholeContents
from mesh_map.io.layer_meanings import layer_meaning
from mesh_map.map.mesh_map import MeshMap

_LOG = logging.getLogger("mesh_map")
_TRIES = 5


# The geometries that maps of this process use now, by all that they are made of.
_GEOMETRIES: "weakref.WeakValueDictionary[Any, MeshGeometry]" = weakref.WeakValueDictionary()
_LOCK = threading.Lock()


def _shared(key: Any, make: Callable[[], MeshGeometry]) -> MeshGeometry:
    """The one of this key that is in use; it is made if there is none, and who asks then waits."""
    with _LOCK:
        found = _GEOMETRIES.get(key)
        if found is None:
            found = _GEOMETRIES[key] = make()
        return found


class MapSource:
    """A mesh that has been read, and the layers stored with it, which are read when needed.

    A mesh with copies of vertices along the seams of textures is one that was derived of the mesh
    without: maps are of that one, so that no seam cuts the surface, and are shown with the copies.

    Attributes: path, is_map_file (HDF5: layers can be saved), mesh (mesh_msgs_hdf5, as in the file;
    geometry, normals and colors), uuid, contents (MapContents), require_provenance (false; true:
    costs_on_trust gives none).
    """

    require_provenance = False

    def __init__(
        self, path: str, part: Optional[str] = None, origin: Optional[Sequence[float]] = None
    ) -> None:
        """Reads a map file, or a mesh in any format that mesh_msgs_hdf5 knows.

        Args:
            path: of the file.
            part: which mesh of a map file; None is "mesh" if there is one, else the only one.
            origin: (3,) meters, subtracted from the coordinates in the file before they are
                rounded to float32; None for none. Map files store theirs: another one is refused.
        Raises:
            MeshMapError: a file that cannot be read as a mesh, or whose coordinates need an origin.
        """
        self.path = path
        try:
            opened = open_members(path, part, origin)
            self._members = opened.members
            self.mesh = self._members.read(("vertex_normals", "vertex_colors", "seam_originals"))
            self.uuid: str = self._members.uuid
        except MapFileError as error:
            raise MeshMapError(str(error)) from error
        self.is_map_file = opened.is_map
        self._check_origin(origin)
        self._check_rounding(opened.rounded)
        self.contents = MapContents(
            self._members, opened.is_map, lambda note: _LOG.warning("%s: %s", path, note)
        )
        self._split = split_mesh(self.mesh, self.uuid)
        self._whole = without_copies(self.mesh)
        self._geometry: Optional[MeshGeometry] = None
        self._derived: Optional[DerivedMesh] = None
        self._options: Dict[str, Any] = {}
        self._identity: Dict[str, Any] = {}
        self._stored: Dict[str, Dict[str, Any]] = {}
        self._stamp: Any = None  # of the file when _stored was read
        for note in opened.notes:
            _LOG.warning("%s: %s", path, note)
        self.contents.tell_notes()

    def _check_origin(self, origin: Optional[Sequence[float]]) -> None:
        stored = tuple(self.mesh.origin)
        if self.is_map_file and origin is not None and tuple(origin) != stored:
            raise MeshMapError(
                "origin is %s, but %s stores %s" % (list(origin), self.path, list(stored)),
                "leave it out; mesh_tool import --origin makes a map file with another one",
            )

    def _check_rounding(self, rounded: float) -> None:
        if not self.is_map_file:
            check_rounding(self.path, rounded, self.mesh.vertices, self.mesh.origin)
            return
        rounded = self._members.vertex_rounding
        if is_too_much(rounded, self.mesh.vertices):
            raise MeshMapError(str(too_much_rounded(self.path, rounded)))

    def make_map(
        self,
        frame_id: str = "",
        up_direction: Any = (0.0, 0.0, 1.0),
        orient: bool = False,
        normals: str = "mean",
        max_edge_length: float = 0.0,
    ) -> MeshMap:
        """A map without layers. All maps of this process with this mesh share what follows from it.

        Args:
            frame_id: instead of that of the file.
            up_direction, orient, normals: as for MeshGeometry.
            max_edge_length: meters; where edges are longer, the map is one of a derived mesh whose
                are not (see mesh_map.geometry.refinement), with a UUID of its own. Labels, stored
                layers and attributes are carried to it from the file, and layers that are saved
                back. 0: the mesh as it is.
        Raises:
            MeshMapError: no usable mesh, or a wrong option.
        """
        mesh, frame_id = self._whole, frame_id or self.mesh.frame_id
        content = self._content_uuid()
        options = {"up_direction": up_direction, "orient": orient, "normals": normals}

        def made() -> MeshGeometry:
            vertices, faces, normals = mesh.vertices, mesh.faces, mesh.vertex_normals
            geometry = MeshGeometry(vertices, faces, normals, frame_id, self.uuid, **options)
            derived = None
            if max_edge_length:
                derived = refine(vertices, faces, max_edge_length, parent_uuid=self.uuid)
            split = self._split
            if derived is None:
                geometry.content_uuid = content
            else:
                geometry = _geometry_of(derived, mesh, frame_id, options)
                if split is not None:
                    split, geometry.split_derived = refined_split(split, derived)
            if split is not None and geometry.orientation is not None:
                split = turned(split, geometry.orientation)
            geometry.split = split
            geometry.origin = read_only(checked_origin(mesh.origin))
            return geometry

        given = "" if mesh.vertex_normals is None else digest(mesh.vertex_normals)
        of_options: Tuple[Any, ...] = tuple(checked_up(up_direction)), bool(orient), repr(normals)
        of_options += (float(max_edge_length),)
        key = (content, self.uuid, frame_id, tuple(mesh.origin), given, of_options)
        self._geometry = _shared(key, made)
        self._options, self._identity = options, {}
        self._derived = derived = self._geometry.derived
        contents: Any = self.contents
        if self._split is not None:
            contents = WholeContents(contents, self._split)
        if derived is not None:
            shown = self._geometry.split, self._geometry.split_derived
            return MeshMap.of(self._geometry, DerivedContents(contents, derived, *shown))
        if given and self._has_usual_normals():
            self._identity["vertex_normals"] = given
        return MeshMap.of(self._geometry, contents)

    @property
    def vertex_colors(self) -> Optional[np.ndarray]:
        """(V, 3) uint8 of the map that was made last, as it is shown, with copies along seams; None
        where the mesh has none."""
        colors, derived = self.mesh.vertex_colors, self._derived
        if colors is None or derived is None:
            return colors
        return (self._geometry.split_derived or derived).vertex_values(colors)

    def _content_uuid(self) -> str:
        # Files of ours are checked for that while they are read, and meshes of other formats have
        # no other UUID.
        if self._split is not None:
            return geometry_uuid(self._whole.vertices, self._whole.faces)
        if self._members.schema_version or not self.is_map_file:
            return self.uuid
        return geometry_uuid(self.mesh.vertices, self.mesh.faces)

    def stored_costs(self, name: str, fingerprint: Mapping[str, Any]) -> Optional[np.ndarray]:
        """The costs in the file of a layer that was computed with this fingerprint, if there are.

        Those under the name of the layer count first, then others: another robot may have stored
        them. Costs of which the file does not say for which geometry they were made are not used
        (see costs_on_trust), nor are those of a damaged or meanwhile replaced file; that is logged.
        A derived mesh has vertices that the file knows nothing of: there are none for it.
        """
        if self._derived is not None:
            return None
        wanted = self._storable(fingerprint)

        def chosen(stored: Mapping[str, Any]) -> Optional[str]:
            names = [other for other in stored if stored[other] == wanted]
            return name if name in names else names[0] if names else None

        try:
            costs, stored = self._stored_costs(chosen)
        except MapFileError as error:
            _LOG.warning("layer %s is computed anew: %s", name, error)
            return None
        if costs is None and stored.get(name):
            _LOG.info("layer %s is computed anew: %s", name, _difference(stored[name], wanted))
        return costs

    def costs_on_trust(self, name: str, released_name: str) -> Optional[np.ndarray]:
        """The costs in the file under the name that the released programs have for a layer's type,
        if the file does not say anything of how they were made: as those programs store them.

        None for a derived mesh, where another way is up than for those programs or faces are
        turned, and where require_provenance is set; that is logged.
        """
        if self._geometry is None or self._derived is not None or not self.is_map_file:
            return None
        turned = self._options.get("orient") or tuple(self._geometry.up) != (0.0, 0.0, 1.0)
        usable = not (self.require_provenance or turned)

        def chosen(stored: Mapping[str, Any]) -> Optional[str]:
            return released_name if usable and stored.get(released_name) == {} else None

        try:
            costs, stored = self._stored_costs(chosen)
        except MapFileError as error:
            _LOG.warning("layer %s is computed anew: %s", name, error)
            return None
        silent = [other for other in (name, released_name) if stored.get(other) == {}]
        if costs is None and silent:
            text = "layer %s is computed anew: the file does not say how, and for which geometry, "
            _LOG.info(text + "the costs of %s were computed", name, silent[0])
        return costs

    def _stored_costs(self, chosen: Callable[[Mapping[str, Any]], Optional[str]]) -> Any:
        """(costs of the layer that is chosen by the parameters of all, None if none is; those)."""
        for _ in range(_TRIES):
            stored = self._stored_parameters()
            name = chosen(stored)
            if name is None:
                break
            costs = self._members.vertex_costs(name)
            if stamp(self.path) == self._stamp:  # so these are the costs of those parameters
                whole = self._split is None
                return (costs if whole else self._split.parent_vertex_values(costs)), stored
        return None, stored

    def is_stored(self, layer: Layer) -> bool:
        """Whether the file has this layer under its name, computed as it was."""
        if self._derived is not None:
            return False
        stored = self._stored_parameters().get(layer.name)
        return stored is not None and stored == self._storable(_identity(layer))

    def _stored_parameters(self) -> Dict[str, Dict[str, Any]]:
        """Layer name -> parameters, as they are in the file now."""
        now = stamp(self.path)
        if self._stamp is None or self._stamp != now:
            stored = self._members.all_layer_parameters()
            self._stored = {name: computed_with(values) for name, values in stored.items()}
            self._stamp = now
        return self._stored

    def save_layers(self, layers: Mapping[str, Layer]) -> List[str]:
        """Writes layers with their parameters to the map file; returns their names.

        Normals of vertices are stored too where the file has none, so that nobody computes them
        again. Layers that say so (STORABLE) are left out. Of a derived mesh, the file gets what the
        parent's vertices have, and for which geometry that was computed: nobody takes it for
        costs that were computed on the parent.

        Raises:
            MeshMapError: no map file, no layers, one that does not say how it was made, or a file
                that cannot be written.
        """
        if not self.is_map_file:
            raise MeshMapError(
                "%s is no map file, so layers cannot be stored in it" % self.path,
                "rosrun mesh_msgs_hdf5 mesh_tool import IN OUT.h5",
            )
        edit = Edit()
        for name, layer in layers.items():
            if layer.result is not None and layer.STORABLE and layer.params["enabled"]:
                costs, meaning = self._for_file(layer.result.costs), layer_meaning(layer)
                if self._derived is not None:  # its numbers are those of other vertices
                    meaning = meaning._replace(lethal=None).counted(costs)
                elif self._split is not None:  # and copies count
                    lethal = np.count_nonzero(self._split.vertex_values(layer.result.lethal))
                    meaning = meaning._replace(lethal=int(lethal)).counted(costs)
                edit.vertex_costs[name] = costs
                identity = _identity(layer)
                on_trust = ON_TRUST in identity  # nobody knows more of them than before
                parameters = {} if on_trust else self._storable(identity)
                edit.layer_parameters[name] = {**parameters, KEY: meaning.stored()}
        if not edit.vertex_costs:
            raise MeshMapError("there are no layers to store")
        try:
            self._update(edit)
        except MapFileError as error:
            raise MeshMapError(str(error)) from error
        return list(edit.vertex_costs)

    def _for_file(self, costs: np.ndarray) -> np.ndarray:
        """Values of the vertices of the map (V, ...), of those of the mesh of the file."""
        costs = costs if self._derived is None else self._derived.parent_vertex_values(costs)
        return costs if self._split is None else self._split.vertex_values(costs)

    def _update(self, edit: Edit) -> None:
        for tries_left in range(_TRIES - 1, -1, -1):
            self._members.layer_names()  # looks at the file as it is now: has_normals follows
            if self._has_usual_normals() and self._derived is None:
                has_normals = self._members.has_normals
                normals = self._geometry.vertex_normals
                edit.vertex_normals = None if has_normals else self._for_file(normals)
            try:
                return self._members.update(edit)
            except MapFileError as error:
                if error.code != "changed" or not tries_left:
                    raise  # else somebody else has saved in this moment

    def _has_usual_normals(self) -> bool:
        options = self._options
        usual = not options.get("orient") and options.get("normals", "mean") == "mean"
        return self._geometry is not None and usual

    def _storable(self, fingerprint: Mapping[str, Any]) -> Dict[str, Any]:
        """The fingerprint as it comes back from the file, with what else costs may follow from."""
        geometry = self._geometry
        if geometry is not None:
            if "vertex_normals" not in self._identity:
                self._identity["vertex_normals"] = digest(geometry.vertex_normals)
            if tuple(geometry.up) != (0.0, 0.0, 1.0):
                self._identity["up_direction"] = geometry.up.tolist()
            if self._options.get("orient"):
                self._identity["orient"] = True
        return json.loads(json.dumps(_finite(dict(fingerprint, **self._identity))))


def _geometry_of(
    derived: DerivedMesh, mesh: Mesh, frame_id: str, options: Mapping[str, Any]
) -> MeshGeometry:
    """That of a derived mesh. The parent's vertices keep normals that the file has; those of new
    vertices follow from the faces, which are flat: between the corners of a box nothing is round.
    """
    geometry = MeshGeometry(
        derived.vertices, derived.faces, None, frame_id, derived.uuid, **options
    )
    geometry.derived = derived
    given = mesh.vertex_normals
    if given is not None and not options["orient"] and options["normals"] == "mean":
        normals = geometry.vertex_normals.copy()
        normals[: len(given)] = unit_normals(given, geometry.up)
        geometry.__dict__["vertex_normals"] = read_only(normals)
    return geometry


def _identity(layer: Layer) -> Mapping[str, Any]:
    try:
        return layer.identity
    except PLUGIN_FAILURES as error:
        text = "layer %s does not say how it was made, so it cannot be stored: %s"
        raise MeshMapError(text % (layer.name, error_line(error))) from error


def _finite(value: Any) -> Any:
    """Infinite numbers as texts: JSON has none."""
    if isinstance(value, Mapping):
        return {str(key): _finite(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(inner) for inner in value]
    return str(value) if isinstance(value, float) and math.isinf(value) else value


def _difference(stored: Mapping[str, Any], wanted: Mapping[str, Any]) -> str:
    """Why costs are not used, for users."""
    if stored == wanted:
        return "other programs change the file all the time"
    if CARRIED_BY in stored:
        return "its costs in the file were carried there by %s" % (stored[CARRIED_BY],)
    if "geometry" not in stored:
        return "the file does not say for which geometry its costs were computed"
    names = sorted(
        name
        for name in set(stored) | set(wanted)
        if name not in stored or name not in wanted or stored[name] != wanted[name]
    )
    return "its costs in the file were computed with other values of " + ", ".join(names)
