"""The base class of all layers, and what a layer gives."""

import abc
from typing import TYPE_CHECKING, Any, ClassVar, Dict, List, Mapping, NamedTuple, Optional, Tuple

import numpy as np

from mesh_map.errors import MeshMapError
from mesh_map.parameter import Parameter, Value

if TYPE_CHECKING:
    from mesh_map.mesh_map import MeshMap

BASE_CLASS_TYPE = "mesh_map::Layer"

FACTOR = Parameter(
    "factor", 1.0, 0.0, 1.0, "weight of the costs in the combination", affects_costs=False
)


class LayerResult(NamedTuple):
    """What a layer gives.

    costs: (V,) float32; finite >= 0 is a cost, +inf is lethal, NaN is unknown.
    lethal: (V,) bool.
    """

    costs: np.ndarray
    lethal: np.ndarray


class Layer(abc.ABC):
    """A cost for each vertex of a map, and which vertices are lethal.

    The contract of a layer plugin:

    * It is described in an XML file that its package.xml exports (see mesh_map.plugins), and
      constructed with its name and parameters, which are checked against PARAMETERS; a plugin need
      not define __init__.
    * compute() gets the map and the results of the layers before it, and returns costs and lethal
      vertices. It must not change the map or the inputs. It may raise MeshMapError with one line
      for users.
    * It does not import rospy and knows nothing of ROS.

    The same type may be used several times in a map under different names.

    Attributes:
        name: unique in its map; also the type of its costs messages and its name in the map file.
        type_name: the name under which the plugin was asked for, such as
            mesh_layers/HeightDiffLayer.
        params: parameter name -> value, all of them.
        warnings: what was odd about the parameters, one line each.
        result: set by the map after compute(); None before.
    """

    PARAMETERS: ClassVar[Tuple[Parameter, ...]] = ()

    def __init__(
        self, name: str, params: Optional[Mapping[str, Any]] = None, type_name: str = ""
    ) -> None:
        """Checks the parameters.

        Raises:
            MeshMapError: one that is NaN or of another type.
        """
        self.name = name
        self.type_name = type_name or type(self).__name__
        self.params: Dict[str, Value] = {}
        self.warnings: List[str] = []
        self.result: Optional[LayerResult] = None
        given = dict(params or {})
        for parameter in self.all_parameters():
            value = given.pop(parameter.name, parameter.default)
            self.params[parameter.name], warning = parameter.checked(value)
            if warning:
                self.warnings.append(warning)
        if given:
            known = ", ".join(sorted(self.params))
            unknown = ", ".join(sorted(map(str, given)))
            self.warnings.append("unknown parameters: %s (known: %s)" % (unknown, known))

    @classmethod
    def all_parameters(cls) -> Tuple[Parameter, ...]:
        """PARAMETERS and the factor that every layer has."""
        return cls.PARAMETERS + (FACTOR,)

    @abc.abstractmethod
    def compute(self, mesh_map: "MeshMap", inputs: Mapping[str, LayerResult]) -> LayerResult:
        """Costs and lethal vertices.

        Args:
            mesh_map: the map; its arrays are read-only.
            inputs: results of the layers before this one, in the order of the list.
        Returns:
            costs (V,), and lethal as (V,) bool or as indices of vertices. Lethal costs (+inf) need
            not be repeated there.
        """

    def reuse(self, costs: np.ndarray) -> Optional[LayerResult]:
        """The result with costs that were computed before with the same stored_parameters().

        None (the default) for a layer that has to be computed, for instance because it depends on
        its inputs.
        """
        return None

    def stored_parameters(self) -> Dict[str, Value]:
        """What is stored with the costs: they may be reused where this is the same."""
        affecting = {p.name: self.params[p.name] for p in self.all_parameters() if p.affects_costs}
        return dict(affecting, type=self.type_name)

    def evaluate(self, mesh_map: "MeshMap", inputs: Mapping[str, LayerResult]) -> LayerResult:
        """compute(), with what it returns checked and brought into the form of LayerResult.

        Raises:
            MeshMapError: arrays of a wrong length or kind, or a negative cost.
        """
        returned = self.compute(mesh_map, inputs)
        try:
            costs, lethal = returned
        except (TypeError, ValueError) as error:
            raise MeshMapError("compute() did not return costs and lethal vertices") from error
        return checked_result(costs, lethal, len(mesh_map.vertices))


def checked_result(costs: Any, lethal: Any, vertex_count: int) -> LayerResult:
    """A LayerResult of V costs, and V booleans or any number of vertex indices.

    Raises:
        MeshMapError: arrays of a wrong length or kind, or a negative cost.
    """
    costs, lethal = np.asarray(costs), np.asarray(lethal)
    if costs.dtype.kind not in "fiu" or costs.shape != (vertex_count,):
        raise MeshMapError(
            "the costs are of shape %s and type %s, but %d numbers are needed, one for each vertex"
            % (costs.shape, costs.dtype, vertex_count)
        )
    if lethal.dtype.kind == "b" and lethal.shape == (vertex_count,):
        mask = lethal.copy()
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
    negative = np.flatnonzero(costs < 0)
    if len(negative):
        raise MeshMapError(
            "the cost of vertex %d is %g (%d negative ones in all)"
            % (negative[0], costs[negative[0]], len(negative)),
            "costs have to be 0 or more, +inf for lethal, NaN for unknown",
        )
    return LayerResult(costs, mask | np.isposinf(costs))
