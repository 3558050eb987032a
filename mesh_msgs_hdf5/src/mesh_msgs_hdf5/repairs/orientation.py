"""Which faces run against their neighbors."""
from typing import Tuple

import numpy as np


def faces_to_flip(faces: np.ndarray) -> Tuple[np.ndarray, int]:
    """(which faces (F,) to turn over, number of faces of one-sided surfaces, which stay).

    faces: (F, 3), each of three different vertices. Two faces that share an edge which no third one
    has agree if they run through it in opposite directions. In each set of faces connected in this
    way the fewer are turned; if as many, those that leave the first face as it is.

    Each face is two nodes of a graph, as it is and turned over; an edge joins the nodes of two
    faces that agree. A surface is one-sided if both nodes of a face are connected.
    """
    # this takes a while to import, and few imports repair
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    count = len(faces)
    one, other, opposite = _neighbors(faces)
    turned = np.where(opposite, 0, count)
    rows = np.concatenate([one, one + count])
    columns = np.concatenate([other + turned, other + count - turned])
    graph = coo_matrix((np.ones(len(rows), np.int8), (rows, columns)), (2 * count, 2 * count))
    groups, group = connected_components(graph, directed=False)
    as_is, over = group[:count], group[count:]
    # a group has a mirror image, in which each face is turned over: take the one with more as is
    kept = np.bincount(as_is, minlength=groups)
    first = np.full(groups, count)
    np.minimum.at(first, as_is, np.arange(count))
    better = (kept[over] > kept[as_is]) | (
        (kept[over] == kept[as_is]) & (first[over] < first[as_is])
    )
    one_sided = as_is == over
    return better & ~one_sided, int(np.count_nonzero(one_sided))


def _neighbors(faces):
    """(face, face, whether they run through their edge in opposite directions) (N,) each."""
    start = faces.reshape(-1).astype(np.int64)
    end = np.roll(faces, -1, axis=1).reshape(-1).astype(np.int64)
    upward = start < end
    low, high = np.minimum(start, end), np.maximum(start, end)
    order = np.lexsort((high, low))
    low, high = low[order], high[order]
    new = np.ones(len(order) + 1, bool)
    new[1:-1] = (low[1:] != low[:-1]) | (high[1:] != high[:-1])
    at = np.flatnonzero(new)
    pairs = at[:-1][np.diff(at) == 2]
    one, other = order[pairs], order[pairs + 1]
    return one // 3, other // 3, upward[one] != upward[other]
