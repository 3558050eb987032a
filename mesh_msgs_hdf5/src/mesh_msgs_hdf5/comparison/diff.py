"""What differs between two meshes, member by member."""
import json
from typing import Any, Callable, Dict, Iterator, List

import numpy as np

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.comparison.diff_geometry import Difference, compare_geometry, moved
from mesh_msgs_hdf5.formats.any_mesh import Members
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.model.label_names import natural_order

MEMBERS = ("geometry", "normals", "colors", "layers", "attributes", "faces", "labels", "textures")
MEMBERS += ("features", "frame", "origin", "source", "other")
# of a mesh's members with names: those of the names, of the values, and of their parameters
_NAMED = {
    "layers": ("layer_names", "vertex_costs", "layer_parameters"),
    "attributes": ("vertex_attribute_names", "vertex_attribute", "vertex_parameters"),
    "faces": ("face_attribute_names", "face_attribute", "face_parameters"),
}


def compare(
    one: Members,
    other: Members,
    tolerance: float = 0.0,
    ignore=(),
    progress: Callable[[str], None] = lambda stage: None,
) -> List[Difference]:
    """The differences between two meshes; no difference: they are the same.

    tolerance: numbers (coordinates in meters, costs, normals, ...) that differ by no more are the
    same; NaN is the same as NaN. ignore: names of MEMBERS. progress: is told each stage. Raises
    MapFileError for a file that cannot be read.
    """
    found: List[Difference] = []
    progress("geometry")
    geometry, vertices, faces = compare_geometry(one, other, tolerance)
    found += geometry if "geometry" not in ignore else []
    parts = {
        "normals": lambda: _normals(one, other, vertices, tolerance),
        "colors": lambda: _colors(one, other, vertices),
        "layers": lambda: _named("layers", one, other, vertices, tolerance),
        "attributes": lambda: _named("attributes", one, other, vertices, tolerance),
        "faces": lambda: _named("faces", one, other, faces, tolerance),
        "labels": lambda: _labels(one, other, faces),
        "textures": lambda: _textures(one, other, vertices, faces, tolerance),
        "features": lambda: _features(one, other, tolerance),
        "frame": lambda: _texts(one, other, ("frame_id", "crs")),
        "origin": lambda: _origins(one, other),
        "source": lambda: _texts(one, other, ("source",)),
        "other": lambda: _others(one, other),
    }
    for name, differences in parts.items():
        if name not in ignore:
            progress(name)
            found += differences()
    return found


def _only(member, ours, theirs) -> Iterator[Difference]:
    for name in _sorted(set(ours) - set(theirs)):
        yield Difference(_place(member, name), "only in one", "only in A", {})
    for name in _sorted(set(theirs) - set(ours)):
        place = _place(member, name)
        yield Difference(place, "only in other", "only in B", {})


def _others(one, other):
    """What else is in two files: of a group that one names as a whole, what the other one names."""
    names = [file.other_contents() for file in (one, other)]
    ways = set()
    for name in names[0] + names[1]:
        while name.rpartition("/")[0]:
            name = name.rpartition("/")[0]
            ways.add(name)
    yield from _only("other", *(file.other_contents(sorted(ways)) for file in (one, other)))


def _place(member, name):
    return "%s/%s" % (member, one_line(str(name)).lstrip("/"))


def _incomparable(member, comparable) -> Iterator[Difference]:
    if not comparable:
        yield Difference(member, "count", "cannot be compared: their numbers differ", {})


def _normals(one, other, comparable, tolerance):
    a, b = one.vertex_normals, other.vertex_normals
    if (yield from _are_there("normals", a, b, comparable)):
        yield from moved("normals", "normals", a, b, tolerance)


def _colors(one, other, comparable):
    a, b = one.vertex_colors, other.vertex_colors
    if (yield from _are_there("colors", a, b, comparable)):
        yield from numbers("colors", a, b, 0.0)


def _are_there(member, a, b, comparable=True):
    """What is to be said of values that may be None; True if they can be compared."""
    if a is None and b is None:
        return False
    if a is None or b is None:
        kind, text = ("only in one", "A") if b is None else ("only in other", "B")
        yield Difference(member, kind, "only in " + text, {})
        return False
    yield from _incomparable(member, comparable)
    return comparable


def numbers(member: str, one, other, tolerance: float) -> Iterator[Difference]:
    """The difference between arrays of one length; each row counts once.

    NaN and inf are only the same as themselves.
    """
    if one.shape != other.shape:
        text = "shape %s in one, %s in the other" % (one.shape, other.shape)
        yield Difference(member, "changed", text, {"one": one.shape, "other": other.shape})
        return
    if one.dtype != other.dtype:
        text = "%s in one, %s in the other" % (one.dtype, other.dtype)
        yield Difference(
            member, "changed", text, {"one": str(one.dtype), "other": str(other.dtype)}
        )
    a, b = (values.reshape(len(values), -1) for values in (one, other))
    same = (a == b) | ((a != a) & (b != b))
    rest = np.flatnonzero(~same.all(axis=1))
    wide = np.longdouble if a.dtype.kind in "iu" and a.dtype.itemsize == 8 else np.float64
    with np.errstate(invalid="ignore"):
        gap = np.where(same[rest], 0, np.abs(a[rest].astype(wide) - b[rest].astype(wide)))
    kind = ~np.isfinite(gap)  # lethal or unknown in one of them only
    beyond = (kind | (gap > tolerance)).any(axis=1)
    if not beyond.any():
        return
    finite = np.where(kind, 0, gap)
    details: Dict[str, Any] = {
        "count": int(np.count_nonzero(beyond)),
        "first": int(rest[beyond.argmax()]),
        "max": float(finite.max()),
        "mean": float(finite.sum() / a.size),
        "not_finite": int(np.count_nonzero(kind.any(axis=1))),
    }
    text = "{count} of %d differ by up to {max:.6g} (mean {mean:.6g}), first {first}" % len(a)
    if details["not_finite"]:
        text += "; {not_finite} are lethal or unknown in one only, or another of the two"
    yield Difference(member, "changed", text.format(**details), details)


def _named(kind, one, other, comparable, tolerance):
    names_of, values_of, parameters_of = _NAMED[kind]
    names = [getattr(file, names_of)() for file in (one, other)]
    yield from _only(kind, *names)
    for name in sorted(set(names[0]) & set(names[1])):
        member = "%s/%s" % (kind, one_line(name))
        yield from _incomparable(member, comparable)
        if comparable:
            yield from _values(member, (one, other), values_of, name, tolerance)
        yield from _parameters(member, *(getattr(f, parameters_of)(name) for f in (one, other)))


def _values(member, files, values_of, name, tolerance):
    """The difference between arrays; one that cannot be read is another than any."""
    found, errors = [], []
    for file, which in zip(files, "AB"):
        try:
            found.append(getattr(file, values_of)(name))
        except MapFileError as error:
            if error.code in ("crashed", "timeout", "changed"):
                raise
            errors.append("%s: %s" % (which, one_line(error.message)))
    if errors:
        yield Difference(member, "unreadable", "cannot be read in " + "; ".join(errors), {})
        return
    a, b = found
    if a.ndim == 3 and a.shape == b.shape:  # of an image, each pixel counts
        a, b = (image.reshape(-1, image.shape[2]) for image in (a, b))
    yield from numbers(member, a, b, tolerance)


def _parameters(member, a, b):
    if json_of(a) != json_of(b):
        text = "parameters %s in one, %s in the other" % (json_of(a), json_of(b))
        yield Difference(member + "/parameters", "changed", text, {"one": a, "other": b})


def json_of(value) -> str:
    """A text that is the same for the same parameters."""
    return json.dumps(value, sort_keys=True, ensure_ascii=False)


def _labels(one, other, comparable):
    ours, theirs = one.labels(), other.labels()
    yield from _only("labels", ours, theirs)
    for text in _sorted(set(ours) & set(theirs)):
        member, a, b = "labels/" + one_line(text), ours[text], theirs[text]
        yield from _incomparable(member, comparable)
        if comparable:
            removed = np.setdiff1d(a.faces, b.faces)
            added = np.setdiff1d(b.faces, a.faces)
            if len(added) or len(removed):
                numbers_of = {"added": len(added), "removed": len(removed)}
                changes = "the other has {added} faces more and lacks {removed}"
                yield Difference(member, "changed", changes.format(**numbers_of), numbers_of)
        if a.color != b.color:
            colors = "color %s in one, %s in the other" % (a.color, b.color)
            yield Difference(member, "changed", colors, {"one": a.color, "other": b.color})


def _textures(one, other, vertices, faces, tolerance):
    indices = [file.texture_indices() for file in (one, other)]
    yield from _only("textures", *indices)
    for index in sorted(set(indices[0]) & set(indices[1])):
        yield from _values("textures/%d" % index, (one, other), "texture", index, 0.0)
    a, b = one.texture_coordinates, other.texture_coordinates
    if (yield from _are_there("texture_coordinates", a, b)) and vertices:
        yield from numbers("texture_coordinates", a, b, tolerance)
    a, b = (file.seam_originals if file.has_seams else None for file in (one, other))
    if (yield from _are_there("seams", a, b)) and vertices:
        yield from numbers("seams", a, b, 0.0)
    a, b = one.materials, other.materials
    if (yield from _are_there("materials", a, b)):
        yield from numbers("materials/colors", a.colors, b.colors, 0.0)
        yield from numbers("materials/textures", a.texture_indices, b.texture_indices, 0.0)
        if faces:
            yield from numbers("materials/faces", a.face_materials, b.face_materials, 0.0)


def _features(one, other, tolerance):
    a, b = one.features, other.features
    if (yield from _are_there("features", a, b)):
        yield from numbers("features/locations", a.locations, b.locations, tolerance)
        yield from numbers("features/descriptors", a.descriptors, b.descriptors, tolerance)


def _origins(one, other):
    a, b = ([float(value) for value in file.origin] for file in (one, other))
    if a != b:
        text = "%s in one, %s in the other" % (a, b)
        yield Difference("origin", "changed", text, {"one": a, "other": b})


def _texts(one, other, names):
    for name in names:
        a, b = getattr(one, name), getattr(other, name)
        if json_of(a) != json_of(b):
            text = "%s in one, %s in the other" % (json_of(a), json_of(b))
            yield Difference(name, "changed", text, {"one": a, "other": b})


def _sorted(names):
    return sorted(names, key=lambda name: natural_order(str(name)))
