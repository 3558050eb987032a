"""Whether a glTF file of ours still has its vertices and faces in the order that its remarks are
about: other programs reorder primitives, and keep the extras."""
import zlib
from typing import Iterable, List, NamedTuple

import numpy as np

from mesh_msgs_hdf5.formats.base.remarks import Remark, about

_KEY = "checksums"


class Order(NamedTuple):
    """faces, vertices: whether what belongs to them by their number still does."""

    faces: bool
    vertices: bool


def order_remark(positions: np.ndarray, faces: Iterable[np.ndarray]) -> Remark:
    """positions: (V, 3) float32 as they stand in the file; faces: (F, 3) of each primitive."""
    return {_KEY: [_sum([positions], "<f4"), _sum(faces, "<u4")]}


def kept_order(remarks: List[Remark], positions: np.ndarray, faces: np.ndarray) -> Order:
    """positions: (V, 3); faces: (F, 3) of all primitives. A file without checksums, as versions
    before had it, is believed; and vertices may move, as long as all faces are the same.
    """
    for remark in about(remarks, _KEY, list)[:1]:
        same = [_sum([positions], "<f4"), _sum([faces], "<u4")]
        if len(remark[_KEY]) == 2:
            of_faces = remark[_KEY][1] == same[1]
            return Order(of_faces, of_faces or remark[_KEY][0] == same[0])
    return Order(True, True)


def _sum(arrays: Iterable[np.ndarray], kind: str) -> int:
    found = 0
    for array in arrays:
        found = zlib.crc32(np.ascontiguousarray(array, kind).tobytes(), found)
    return found
