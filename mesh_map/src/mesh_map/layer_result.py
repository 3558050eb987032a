"""What a layer gives, what it gets of others, and the checks of what plugins return."""

from typing import Any, List, Mapping, NamedTuple, Optional

import numpy as np

from mesh_map.array_checks import read_only
from mesh_map.digest import digest
from mesh_map.errors import MeshMapError


class LayerResult(NamedTuple):
    """What a layer gives.

    costs: (V,) float32; finite >= 0 is a cost, +inf is lethal, NaN is unknown.
    lethal: (V,) bool; True wherever the cost is +inf, and where the layer says so.
    vectors: (V, 3) float32, a direction in which to be drawn at each vertex, zero where there is
        none, such as away from obstacles; None for a layer without.
    """

    costs: np.ndarray
    lethal: np.ndarray
    vectors: Optional[np.ndarray] = None


class LayerInput(NamedTuple):
    """What a layer reads of another one: its result, and its combination_weight."""

    costs: np.ndarray
    lethal: np.ndarray
    vectors: Optional[np.ndarray]
    weight: float


def checked(returned: Any, vertex_count: int) -> LayerResult:
    """What compute() or update() returned, in the form of LayerResult.

    Raises:
        MeshMapError: arrays of a wrong length or kind, or a negative cost.
    """
    try:
        costs, lethal, *vectors = returned
        (vectors,) = vectors or (None,)
    except (TypeError, ValueError) as error:
        raise MeshMapError("compute() did not return costs and lethal vertices") from error
    return checked_result(costs, lethal, vertex_count, vectors)


def checked_result(
    costs: Any, lethal: Any, vertex_count: int, vectors: Optional[Any] = None
) -> LayerResult:
    """A LayerResult of V costs, V booleans or any number of vertex indices, and (V, 3) vectors.

    Its arrays are read-only; what the caller could still write to is copied.

    Raises:
        MeshMapError: arrays of a wrong length or kind, or a negative cost.
    """
    given_costs, given_vectors = costs, vectors
    costs, lethal = np.asarray(costs), np.asarray(lethal)
    if costs.dtype.kind not in "fiu" or costs.shape != (vertex_count,):
        raise MeshMapError(
            "the costs are of shape %s and type %s, but %d numbers are needed, one for each vertex"
            % (costs.shape, costs.dtype, vertex_count)
        )
    if lethal.dtype.kind == "b" and lethal.shape == (vertex_count,):
        mask = lethal
    elif lethal.ndim == 1 and (lethal.dtype.kind in "iu" or not len(lethal)):
        indices = lethal.astype(np.int64)
        if len(indices) and not 0 <= indices.min() <= indices.max() < vertex_count:
            raise MeshMapError("a lethal vertex does not exist: there are %d" % vertex_count)
        mask = np.zeros(vertex_count, np.bool_)
        mask[indices] = True
    else:
        raise MeshMapError("the lethal vertices have to be %d booleans or indices" % vertex_count)
    with np.errstate(over="ignore"):  # what does not fit is lethal
        costs = np.ascontiguousarray(costs, np.float32)
    negative = costs < 0
    if negative.any():
        negative = np.flatnonzero(negative)
        raise MeshMapError(
            "the cost of vertex %d is %g (%d negative ones in all)"
            % (negative[0], costs[negative[0]], len(negative)),
            "costs have to be 0 or more, +inf for lethal, NaN for unknown",
        )
    if vectors is not None:
        with np.errstate(over="ignore"):  # what does not fit is not finite
            vectors = np.ascontiguousarray(vectors, np.float32)
        if vectors.shape != (vertex_count, 3) or not np.isfinite(vectors).all():
            raise MeshMapError("the vectors have to be (%d, 3) finite numbers" % vertex_count)
        vectors = _of_its_own(vectors, given_vectors)
    mask = mask | (costs == np.inf)
    return LayerResult(_of_its_own(costs, given_costs), read_only(mask), vectors)


def digest_of_inputs(inputs: Mapping[str, LayerInput], weights: bool = True) -> str:
    """A digest of names, costs, lethal vertices and vectors of inputs, and of their weights."""
    parts: List[Any] = []
    for name, read in inputs.items():
        parts += [name, repr(read.weight) if weights else "", read.costs, read.lethal]
        parts.append("" if read.vectors is None else read.vectors)
    return digest(*parts)


def _of_its_own(array: np.ndarray, given: Any) -> np.ndarray:
    """Read-only, and nobody else can write to it: a layer may use its buffers again."""
    if (
        isinstance(given, np.ndarray)
        and given.flags.writeable
        and np.may_share_memory(array, given)
    ):
        array = array.copy()
    return read_only(array)
