"""Received messages as changes of a map file.

Each function takes a message (of mesh_msgs.arrays or a generated class) and the map that it belongs
to (a MapFile, or what has its interface), checks the one against the other and returns a Received;
or it raises Refused, whose text is a sentence for the log. The inverse of map_messages: what is
served of a map and received again is the same, bit for bit. Frames of the headers are not looked
at: values of vertices and faces have no place of their own.
"""
from dataclasses import dataclass, field
from typing import Any, Hashable, List

import numpy as np
from mesh_msgs import validation

from mesh_msgs_hdf5.checks.check import checked_features, checked_label
from mesh_msgs_hdf5.model.edit import CostsUpdate, Edit
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials
from mesh_msgs_hdf5.model.schema import check_face_attribute_name, check_layer_name
from mesh_msgs_hdf5.ros.sent_names import sent_name_fault
from mesh_msgs_hdf5.server.map_overlay import layer_or_none

# encoding -> (channels, which of them are red, green, blue and alpha)
_ENCODINGS = {
    "rgb8": (3, (0, 1, 2)),
    "rgba8": (4, (0, 1, 2, 3)),
    "bgr8": (3, (2, 1, 0)),
    "bgra8": (4, (2, 1, 0, 3)),
    "mono8": (1, (0, 0, 0)),
}
_NO_MATERIAL = (204, 204, 204)  # of faces that are in no cluster: light gray
_MAX_TEXTURE = 2**31 - 1  # a file keeps indices as int32


class Refused(ValueError):
    """A message that cannot be stored."""


@dataclass
class Received:
    """What a message changes.

    edit: the change. member, key: what of the map it is (a member of Edit; the name or index in a
    dictionary, else None). notes: sentences about what could not be kept as it was sent.
    """

    edit: Edit
    member: str
    key: Hashable = None
    notes: List[str] = field(default_factory=list)


def vertex_costs(message: Any, target: Any) -> Received:
    """MeshVertexCostsStamped: a layer, which replaces one of that name and its parameters."""
    _check(validation.mesh_vertex_costs(message.mesh_vertex_costs, target.vertex_count))
    _check_layer(message, target)
    costs = _floats(message.mesh_vertex_costs.costs)
    return Received(Edit(vertex_costs={message.type: costs}), "vertex_costs", message.type)


def vertex_costs_update(message: Any, target: Any) -> Received:
    """MeshVertexCostsSparseStamped: some values of a layer.

    A layer that the map has not is made of default_value. Where a vertex is named twice, the last
    value counts. All others stay as they are in the file when it is saved: another program may have
    saved them meanwhile.
    """
    sparse = message.mesh_vertex_costs
    _check(validation.mesh_vertex_costs_sparse(sparse, target.vertex_count))
    _check_layer(message, target)
    there = layer_or_none(target, message.type)
    count, default = target.vertex_count, sparse.default_value
    costs = np.full(count, default, np.float32) if there is None else np.array(there)
    changed = np.zeros(target.vertex_count, bool)
    vertices = np.asarray(sparse.vertices, np.int64)
    costs[vertices], changed[vertices] = _floats(sparse.costs), True
    update = CostsUpdate(changed, float(sparse.default_value))
    edit = Edit(vertex_costs={message.type: costs}, costs_updates={message.type: update})
    return Received(edit, "vertex_costs", message.type)


def _check_layer(message, target):
    _check_sent(message.type)
    _allowed(check_layer_name, target.path, message.type)
    if message.type in target.unsaved.vertex_costs:
        return  # it was looked at before
    try:
        names = target.vertex_attribute_names()
    except MapFileError:  # what is wrong with the file is said when it is saved
        return
    if message.type in names:
        raise Refused(
            "%r is a vertex attribute of the map (class ids, ...): a layer needs another name"
            % message.type
        )


def face_costs(message: Any, target: Any) -> Received:
    """MeshFaceCostsStamped: a face attribute, which replaces one of that name."""
    _check(validation.mesh_face_costs(message.mesh_face_costs, target.face_count))
    _check_sent(message.type)
    _allowed(check_face_attribute_name, target.path, message.type)
    costs = _floats(message.mesh_face_costs.costs)
    return Received(Edit(face_attributes={message.type: costs}), "face_attributes", message.type)


def vertex_colors(message: Any, target: Any) -> Received:
    """MeshVertexColorsStamped: the nearest of 256 steps of each color; alpha is not kept."""
    colors = message.mesh_vertex_colors
    _check(validation.mesh_vertex_colors(colors, target.vertex_count))
    values = _rows(colors.vertex_colors, "r", "g", "b", "a")
    received = Received(Edit(vertex_colors=to_bytes(values[:, :3])), "vertex_colors")
    clear = np.flatnonzero(values[:, 3] != 1)
    if len(clear):
        received.notes.append(
            "alpha of %d vertex colors is not 1 (first at vertex %d) and is not kept: vertex "
            "colors of a map are opaque" % (len(clear), clear[0])
        )
    return received


def materials(message: Any, target: Any) -> Received:
    """MeshMaterialsStamped: materials and texture coordinates, in place of all that were there.

    A file keeps one material for each face: where clusters share faces, the last of them counts;
    faces in no cluster get a gray material behind the others.
    """
    parts = message.mesh_materials
    _check(validation.mesh_materials(parts, target.vertex_count, target.face_count))
    coordinates = _rows(parts.vertex_tex_coords, "u", "v")
    received = Received(Edit(), "materials")
    if len(coordinates):
        received.edit.texture_coordinates = coordinates
    else:
        received.edit.remove |= {"texture_coordinates"}
    if len(parts.materials):
        received.edit.materials = _materials(parts, target.face_count, received.notes)
    elif len(parts.clusters):
        raise Refused("there are clusters, but no materials; send a material for each cluster")
    else:
        received.edit.remove |= {"materials"}
    return received


def _materials(parts, face_count, notes):
    colors = [[m.color.r, m.color.g, m.color.b] for m in parts.materials]
    textures = [m.texture_index if m.has_texture else -1 for m in parts.materials]
    for number, index in enumerate(textures):
        if index > _MAX_TEXTURE:
            raise Refused(
                "material %d has the texture index %d; indices end at %d, and a material without "
                "texture has has_texture false" % (number, index, _MAX_TEXTURE)
            )
    face_materials = np.full(face_count, len(colors), np.uint32)
    shared = 0
    for cluster, material in zip(parts.clusters, parts.cluster_materials):
        faces = np.asarray(cluster.face_indices, np.int64)
        earlier = face_materials[faces]
        shared += np.count_nonzero((earlier != len(colors)) & (earlier != material))
        face_materials[faces] = material
    if shared:
        notes.append("%d faces are in several clusters: the last of them counts" % shared)
    bare = np.flatnonzero(face_materials == len(colors))
    if len(bare):
        notes.append(
            "%d faces are in no cluster (first %d): they get a gray material" % (len(bare), bare[0])
        )
    names = [cluster.label for cluster in parts.clusters if cluster.label]
    if names:
        notes.append("labels of clusters of materials are not kept (first %r)" % names[0][:80])
    alphas = [number for number, m in enumerate(parts.materials) if m.color.a != 1]
    if alphas:
        notes.append(
            "alpha of %d materials is not 1 (first of material %d) and is not kept"
            % (len(alphas), alphas[0])
        )
    rgb = to_bytes(np.array(colors, np.float32))
    if len(bare):
        rgb = np.concatenate([rgb, np.array([_NO_MATERIAL], np.uint8)])
        textures.append(-1)
    return Materials(rgb, np.array(textures, np.int32), face_materials)


def texture(message: Any, target: Any) -> Received:
    """MeshTexture: an image in place of the one of that index; bgr8 and mono8 become rgb."""
    _check(validation.mesh_texture(message))
    image, index = message.image, message.texture_index
    if image.encoding not in _ENCODINGS:
        raise Refused(
            "texture %d has the encoding %s, which a map file does not keep; send one of %s"
            % (index, image.encoding[:60], ", ".join(_ENCODINGS))
        )
    if index > _MAX_TEXTURE:
        raise Refused("the texture index is %d; indices end at %d" % (index, _MAX_TEXTURE))
    channels, order = _ENCODINGS[image.encoding]
    rows = np.frombuffer(image.data, np.uint8, image.height * image.step)
    rows = rows.reshape(image.height, image.step)[:, : image.width * channels]
    pixels = rows.reshape(image.height, image.width, channels)[:, :, list(order)]
    edit = Edit(textures={index: np.ascontiguousarray(pixels)})
    return Received(edit, "textures", index)


def features(message: Any, target: Any) -> Received:
    """MeshFeatures: in place of all features; none at all removes them."""
    _check(validation.mesh_features(message))
    if not message.features:
        return Received(Edit(remove=frozenset({"features"})), "features")
    places = [(f.location.x, f.location.y, f.location.z) for f in message.features]
    numbers = [[number.data for number in f.descriptor] for f in message.features]
    if not numbers[0]:
        raise Refused("the features have no descriptors; send at least one number for each")
    found = Features(np.array(places, np.float32), np.array(numbers, np.float32))
    return Received(Edit(features=_allowed(checked_features, target.path, found)), "features")


def label(message: Any, target: Any) -> Label:
    """The faces of a MeshFaceClusterStamped; its text is message.cluster.label."""
    cluster = message.cluster
    _check(validation.mesh_face_cluster(cluster, target.face_count))
    _check_sent(cluster.label)
    faces = np.array(cluster.face_indices, np.uint32)
    return _allowed(checked_label, target.path, cluster.label, Label(faces), target.face_count)


def to_bytes(colors: np.ndarray) -> np.ndarray:
    """Colors from 0 to 1 as uint8: the nearest; the exact inverse of bytes / 255."""
    return np.rint(colors * np.float32(255)).astype(np.uint8)


def _check_sent(name):
    fault = sent_name_fault(name)
    if fault:
        raise Refused(fault)


def _check(findings):
    if findings:
        raise Refused(str(findings[0]))


def _allowed(check, *arguments):
    """What a check of map files returns; its error is a Refused."""
    try:
        return check(*arguments)
    except MapFileError as error:
        raise Refused("; ".join(filter(None, (error.message, error.hint)))) from error


def _floats(values):
    """A copy: an array of a received message is a view of the whole message's bytes."""
    return np.array(values, np.float32)


def _rows(values, *members):
    if isinstance(values, np.ndarray):
        return np.array(values, np.float32)
    rows = [[getattr(item, name) for name in members] for item in values]
    return np.array(rows, np.float32).reshape(-1, len(members))
