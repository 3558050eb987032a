"""What differs between the vertices and faces of two meshes."""
from typing import Any, Dict, Iterator, List, NamedTuple, Tuple

import numpy as np

_BLOCK = 1 << 20


class Difference(NamedTuple):
    """member: what differs, such as "vertices", "layers/slope" or "labels/tree_1"; kind: "count",
    "changed", "only in one", "only in other", or "same" for a remark on the others; text: a
    sentence; details: numbers for programs.
    """

    member: str
    kind: str
    text: str
    details: Dict[str, Any]

    def line(self) -> str:
        """For a person."""
        return "%s: %s" % (self.member, self.text)


def compare_geometry(one, other, tolerance: float) -> Tuple[List[Difference], bool, bool]:
    """(differences, same vertices, same faces) of two meshes given by their members.

    The latter two: whether the values of vertices and of faces can be compared one by one.
    """
    sizes = [(m.vertex_count, m.face_count) for m in (one, other)]
    vertices, faces = [one.vertices, other.vertices], [one.faces, other.faces]
    same = [sizes[0][i] == sizes[1][i] for i in range(2)]
    found: List[Difference] = []
    for i, name in enumerate(("vertices", "faces")):
        if not same[i]:
            text = "%d in one, %d in the other" % (sizes[0][i], sizes[1][i])
            details = {"one": sizes[0][i], "other": sizes[1][i]}
            found.append(Difference(name, "count", text, details))
    if same[0]:
        found += moved("vertices", "vertices", vertices[0], vertices[1], tolerance)
    if same[1]:
        changed = (faces[0] != faces[1]).any(axis=1)
        if changed.any():
            number, first = int(np.count_nonzero(changed)), int(changed.argmax())
            text = "%d have other vertices, first face %d" % (number, first)
            found.append(Difference("faces", "changed", text, {"count": number, "first": first}))
    if found and not (all(same) and len(found) == 1 and found[0].member == "vertices"):
        found.insert(0, _triangles(vertices, faces))
    return found, same[0], same[1]


def moved(member, what, one, other, tolerance: float) -> Iterator[Difference]:
    """The difference between points (N, 3), if any moved by more than the tolerance in meters."""
    count, first, most, total = 0, None, 0.0, 0.0
    for start in range(0, len(one), _BLOCK):
        here = slice(start, start + _BLOCK)
        way = np.linalg.norm(one[here].astype(np.float64) - other[here], axis=1)
        beyond = way > tolerance
        if beyond.any() and first is None:
            first = start + int(beyond.argmax())
        count += int(np.count_nonzero(beyond))
        most, total = max(most, float(way.max())), total + float(way.sum())
    if count:
        details: Dict[str, Any] = {"count": count, "first": first, "max": most}
        details["mean"] = total / len(one)
        text = "%d of %d %s differ by up to %.6g (mean %.6g), first %d"
        text = text % (count, len(one), what, most, details["mean"], first)
        yield Difference(member, "changed", text, details)


def _triangles(vertices, faces):
    """How many triangles, as three places in their order around, only one of the two has."""
    places = np.concatenate(vertices) + np.float32(0)  # -0 is 0
    _, place = np.unique(places.view(np.dtype((np.void, 12))), return_inverse=True)
    corners = np.concatenate([faces[0].astype(np.int64), faces[1] + len(vertices[0])])
    corners = place.reshape(-1)[corners]
    turn = (corners.argmin(axis=1)[:, None] + np.arange(3)) % 3  # the least comes first
    corners = np.ascontiguousarray(np.take_along_axis(corners, turn, axis=1))
    _, kind = np.unique(corners.view(np.dtype((np.void, 24))), return_inverse=True)
    kind = kind.reshape(-1)
    kinds = int(kind.max()) + 1 if len(kind) else 0
    number = [np.bincount(k, minlength=kinds) for k in np.split(kind, [len(faces[0])])]
    only = [int(np.clip(number[i] - number[1 - i], 0, None).sum()) for i in range(2)]
    details = {"only_in_one": only[0], "only_in_other": only[1]}
    if not any(only):
        text = "every triangle is in both, at the same place: only numbers or order differ"
    else:
        text = "%d are only in A, %d only in B (by their places)" % tuple(only)
    return Difference("triangles", "same" if not any(only) else "changed", text, details)
