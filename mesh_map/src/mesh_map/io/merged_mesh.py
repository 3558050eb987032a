"""One mesh of several, with all that they have."""

import hashlib
import re
from typing import (
    Any,
    Callable,
    Collection,
    Dict,
    List,
    Mapping,
    Optional,
    Sequence,
    Tuple,
)

import numpy as np
from mesh_msgs_hdf5.formats.base.remap import take_vertices
from mesh_msgs_hdf5.model.carried_mesh import carried_parameters
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials, Mesh

from mesh_map.base.errors import MeshMapError
from mesh_map.geometry.mesh_geometry import MeshGeometry
from mesh_map.io.merged_parameters import (
    Holders,
    NamedMesh,
    shared_meanings,
    shared_parameters,
)

# Of faces, and vertices, that have no color where others have.
_WHITE, _GRAY = 255, 191
# Rounding by more than the first (m), and than this part of the median edge, is refused.
_NOTICED, _LARGEST_PART = 1e-5, 0.1
_Material = Tuple[Any, int]  # color, texture index
_INSTANCE = re.compile(r"(.*_)(\d+)", re.DOTALL)


def merged(meshes: Sequence[NamedMesh]) -> Tuple[Mesh, List[str]]:
    """The vertices and faces of all, one after the other, near the origin of the first.

    What only some of them have, the others get: unknown layers (NaN), face attributes of NaN or 0,
    white vertices, a gray material, normals of their faces. A label tree_1 of another mesh than the
    first that has one gets the next number that is free; other labels of one name become one. What
    layers were computed with is left out: on the whole, they would be others. What their values
    mean, and parameters of attributes, stay where all that have the layer have the same.

    Returns:
        The mesh, and notes of what was filled in, renamed or left out.
    Raises:
        MeshMapError: other frames or reference systems, or places so far from each other that
            float32 would round coordinates too much.
    """
    first = meshes[0].mesh
    for what in ("frame_id", "crs"):
        values = [getattr(each.mesh, what) for each in meshes]
        for each, value in zip(meshes, values):
            if value != values[0]:
                raise MeshMapError(
                    "%s of %s is %r, that of %s %r"
                    % (what, each.name, value, meshes[0].name, values[0]),
                    "make them one by mesh_tool import --frame or --crs",
                )
    notes: List[str] = []
    all_vertices, shifts = _placed(meshes)
    counts = [len(each.mesh.vertices) for each in meshes]
    starts = np.cumsum([0, *counts])
    mesh = Mesh(
        all_vertices,
        np.concatenate([each.mesh.faces + np.uint32(s) for each, s in zip(meshes, starts)]),
        frame_id=first.frame_id,
        origin=first.origin,
        crs=first.crs,
        source={"merged": [{"name": each.name, "source": each.mesh.source} for each in meshes]},
    )
    mesh.vertex_normals = _filled(
        meshes, "vertex_normals", "normals of their faces", _normals, notes
    )
    mesh.vertex_colors = _filled(meshes, "vertex_colors", "white", _white, notes)
    mesh.texture_coordinates = _filled(meshes, "texture_coordinates", "0", _zeros, notes)
    layers = [each.mesh.vertex_costs for each in meshes]
    parameters = [each.mesh.layer_parameters for each in meshes]
    mesh.vertex_costs, holders = _joined(meshes, layers, counts, "layer", notes)
    meanings = shared_meanings(meshes, parameters, holders, notes)
    mesh.layer_parameters = carried_parameters(mesh.vertex_costs, meanings, "merge")
    taken = set(mesh.vertex_costs)
    own, what = [each.mesh.vertex_attributes for each in meshes], "vertex attribute"
    mesh.vertex_attributes, holders = _joined(meshes, own, counts, what, notes, taken)
    parameters = [each.mesh.vertex_parameters for each in meshes]
    mesh.vertex_parameters = shared_parameters(meshes, parameters, holders, what, notes)
    attributes, what = [each.mesh.face_attributes for each in meshes], "face attribute"
    face_counts = [len(each.mesh.faces) for each in meshes]
    mesh.face_attributes, holders = _joined(meshes, attributes, face_counts, what, notes)
    parameters = [each.mesh.face_parameters for each in meshes]
    mesh.face_parameters = shared_parameters(meshes, parameters, holders, what, notes)
    mesh.labels = _labels(meshes, np.cumsum([0, *face_counts]), notes)
    _take_materials(mesh, meshes, notes)
    _take_features(mesh, meshes, shifts, notes)
    return _with_copies_last(mesh, meshes), notes


def _with_copies_last(mesh: Mesh, meshes: Sequence[NamedMesh]) -> Mesh:
    """The mesh with copies along seams, which each has behind its own vertices, behind all."""
    counts = [len(each.mesh.vertices) for each in meshes]
    own = [len(each.mesh.parent_vertices) for each in meshes]
    is_copy = np.concatenate([np.arange(n) >= k for n, k in zip(counts, own)])
    if not is_copy.any():
        return mesh
    rows = np.argsort(is_copy, kind="stable")
    number = np.argsort(rows).astype(np.uint32)
    result = take_vertices(mesh, rows)
    result.faces = number[mesh.faces]
    tables = [each.mesh.seam_originals for each in meshes]
    starts = np.cumsum([0, *own])
    result.seam_originals = np.concatenate(
        [table + np.uint32(s) for table, s in zip(tables, starts) if table is not None]
    )
    return result


def _placed(meshes: Sequence[NamedMesh]) -> Tuple[np.ndarray, List[np.ndarray]]:
    """All vertices relative to the origin of the first mesh, and what was added to each mesh."""
    shifts = [np.subtract(each.mesh.origin, meshes[0].mesh.origin) for each in meshes]
    parts, lost = [], 0.0
    for each, shift in zip(meshes, shifts):
        exact = each.mesh.vertices.astype(np.float64) + shift
        parts.append(exact.astype(np.float32))
        lost = max(lost, float(np.abs(parts[-1] - exact).max(initial=0.0)))
    if lost > max(_NOTICED, _LARGEST_PART * float(np.median(_lengths(meshes)))):
        raise MeshMapError(
            "float32 would change coordinates by up to %.3g m so far from the origin of %s"
            % (lost, meshes[0].name),
            "give them origins near each other: mesh_tool import --origin",
        )
    return np.concatenate(parts), shifts


def _lengths(meshes: Sequence[NamedMesh]) -> np.ndarray:
    """Meters, of the edges of all faces."""
    found = []
    for each in meshes:
        corners = each.mesh.vertices[each.mesh.faces].astype(np.float64)
        found.append(np.linalg.norm(np.roll(corners, -1, 1) - corners, axis=2).ravel())
    return np.concatenate(found)


def _filled(
    meshes: Sequence[NamedMesh],
    member: str,
    text: str,
    fill: Callable[[Mesh], np.ndarray],
    notes: List[str],
) -> Optional[np.ndarray]:
    values = [getattr(each.mesh, member) for each in meshes]
    lacking = [each.name for each, value in zip(meshes, values) if value is None]
    if len(lacking) == len(meshes):
        return None
    if lacking:
        what = member.replace("vertex_", "").replace("_", " ")
        notes.append("no %s in %s: %s" % (what, ", ".join(lacking), text))
    pairs = zip(meshes, values)
    return np.concatenate([fill(each.mesh) if value is None else value for each, value in pairs])


def _normals(mesh: Mesh) -> np.ndarray:
    return MeshGeometry(mesh.vertices, mesh.faces).vertex_normals


def _white(mesh: Mesh) -> np.ndarray:
    return np.full((len(mesh.vertices), 3), _WHITE, np.uint8)


def _zeros(mesh: Mesh) -> np.ndarray:
    return np.zeros((len(mesh.vertices), 2), np.float32)


def _joined(
    meshes: Sequence[NamedMesh],
    of_each: Sequence[Mapping[str, np.ndarray]],
    counts: Sequence[int],
    what: str,
    notes: List[str],
    taken: Collection[str] = (),
) -> Tuple[Dict[str, np.ndarray], Dict[str, Holders]]:
    """Named values of all, and who had them; of those with one name, but of another type, or a name
    that is taken already, each has its own name."""
    found: Dict[str, np.ndarray] = {}
    held: Dict[str, Holders] = {}
    for name in dict.fromkeys(name for values in of_each for name in values):
        kinds: Dict[Any, List[int]] = {}
        for index, values in enumerate(of_each):
            if name in values:
                kinds.setdefault((values[name].shape[1:], values[name].dtype), []).append(index)
        for (shape, dtype), holders in kinds.items():
            own = (
                name
                if name not in found and name not in taken
                else _free(name.replace("%", "%%") + "_%d", {*found, *taken, *of_each[holders[0]]})
            )
            fill = np.nan if dtype.kind == "f" else 0
            parts = [
                of_each[i][name] if i in holders else np.full((counts[i], *shape), fill, dtype)
                for i in range(len(meshes))
            ]
            found[own], held[own] = np.concatenate(parts), Holders(name, holders)
            lacking = [meshes[i].name for i in range(len(meshes)) if i not in holders]
            if lacking:
                text = "no %s %s in %s: %s" % (what, own, ", ".join(lacking), fill)
                notes.append(text.replace(": nan", ": unknown (NaN)"))
            if own != name:
                owner = meshes[holders[0]].name
                notes.append(
                    "%s %s of %s is %s: there is another one, of another type"
                    % (what, name, owner, own)
                )
    return found, held


def _free(pattern: str, taken: Any, start: int = 2) -> str:
    number = start
    while pattern % number in taken:
        number += 1
    return pattern % number


def _labels(meshes: Sequence[NamedMesh], starts: np.ndarray, notes: List[str]) -> Dict[str, Label]:
    found: Dict[str, Label] = {}
    all_names = {text for each in meshes for text in each.mesh.labels}
    renamed = []
    for each, start in zip(meshes, starts):
        for text, label in each.mesh.labels.items():
            faces = label.faces + np.uint32(start)
            instance = _INSTANCE.fullmatch(text)
            if text in found and instance:
                pattern = instance[1].replace("%", "%%") + "%d"
                new = _free(pattern, all_names, int(instance[2]) + 1)
                all_names.add(new)
                renamed.append("%s of %s is %s" % (text, each.name, new))
                found[new] = Label(faces, label.color)
            elif text in found:
                before = found[text]
                found[text] = Label(
                    np.concatenate([before.faces, faces]), before.color or label.color
                )
            else:
                found[text] = Label(faces, label.color)
    if renamed:
        more = ", and %d more" % (len(renamed) - 5) if len(renamed) > 5 else ""
        notes.append("labels that several have: " + ", ".join(renamed[:5]) + more)
    return found


def _take_materials(mesh: Mesh, meshes: Sequence[NamedMesh], notes: List[str]) -> None:
    """Materials and textures; those that are equal to one of a mesh before are that one."""
    if all(each.mesh.materials is None and not each.mesh.textures for each in meshes):
        return
    rows: List[_Material] = []
    of_faces, lacking = [], []
    known_images: Dict[Any, int] = {}
    known_materials: Dict[_Material, int] = {}
    for each in meshes:
        materials = each.mesh.materials
        if materials is None:
            lacking.append(each.name)
            gray, none = np.full((1, 3), _GRAY, np.uint8), np.full(1, -1, np.int32)
            materials = Materials(gray, none, np.zeros(len(each.mesh.faces), np.uint32))
        texture, new_images = {-1: -1}, {}
        for index, image in sorted(each.mesh.textures.items()):
            key = image.shape, hashlib.sha256(np.ascontiguousarray(image)).digest()
            if key not in known_images:
                # the first mesh keeps its numbers
                texture[index] = max(index, max(mesh.textures, default=-1) + 1)
                mesh.textures[texture[index]] = image
                new_images.setdefault(key, texture[index])
            else:
                texture[index] = known_images[key]
        known_images.update(new_images)
        numbers, new_materials = [], {}
        indices = [texture[index] for index in materials.texture_indices.tolist()]
        for material in zip(map(tuple, materials.colors.tolist()), indices):
            if material not in known_materials:
                rows.append(material)
                new_materials.setdefault(material, len(rows) - 1)
            numbers.append(known_materials.get(material, len(rows) - 1))
        known_materials.update(new_materials)
        of_faces.append(np.array(numbers, np.uint32)[materials.face_materials])
    if lacking:
        notes.append("no materials in %s: gray" % ", ".join(lacking))
    mesh.materials = Materials(
        np.array([color for color, _ in rows], np.uint8).reshape(-1, 3),
        np.array([index for _, index in rows], np.int32),
        np.concatenate(of_faces),
    )


def _take_features(
    mesh: Mesh, meshes: Sequence[NamedMesh], shifts: Sequence[np.ndarray], notes: List[str]
) -> None:
    having = [
        (each, shift) for each, shift in zip(meshes, shifts) if each.mesh.features is not None
    ]
    widths = [each.mesh.features.descriptors.shape[1:] for each, _ in having]
    alike = [pair for pair, width in zip(having, widths) if width == widths[0]]
    for (each, _), width in zip(having, widths):
        if width != widths[0]:
            notes.append("left out: texture features of %s, which are of another kind" % each.name)
    if alike:
        places = [each.mesh.features.locations + shift for each, shift in alike]
        kinds = [each.mesh.features.descriptors for each, _ in alike]
        mesh.features = Features(np.concatenate(places).astype(np.float32), np.concatenate(kinds))
