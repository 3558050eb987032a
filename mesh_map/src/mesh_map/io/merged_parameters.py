"""What is said of the layers and attributes of several meshes, for the one that is made of them."""

from typing import Any, Callable, Dict, List, Mapping, NamedTuple, Sequence

from mesh_msgs_hdf5.model.layer_meaning import KEY, meaning_of
from mesh_msgs_hdf5.model.mesh import Mesh


class NamedMesh(NamedTuple):
    """A mesh, and what it is called in notes."""

    name: str
    mesh: Mesh


class Holders(NamedTuple):
    """The name that some values have in meshes, and which meshes these are (numbers)."""

    name: str
    numbers: List[int]


Parameters = Mapping[str, Mapping[str, Any]]  # by name


def shared_parameters(
    meshes: Sequence[NamedMesh],
    parameters: Sequence[Parameters],
    held: Mapping[str, Holders],
    what: str,
    notes: List[str],
) -> Dict[str, Dict[str, Any]]:
    """Those that all holders of some values have; others are left out, with a note.

    parameters: of each mesh; held: the names of the values now -> who had them.
    """

    def said(values: Mapping[str, Any]) -> Dict[str, Any]:
        return dict(values)

    return _shared(meshes, parameters, held, said, "parameters of %s" % what, notes)


def shared_meanings(
    meshes: Sequence[NamedMesh],
    parameters: Sequence[Parameters],
    held: Mapping[str, Holders],
    notes: List[str],
) -> Dict[str, Dict[str, Any]]:
    """The same of what the values of layers mean (mesh_msgs_hdf5.model.layer_meaning), without
    their numbers."""

    def said(values: Mapping[str, Any]) -> Dict[str, Any]:
        meaning = meaning_of(values)
        if meaning is None:
            return {}
        stored = meaning._replace(lethal=None, unknown=None).stored()
        return {KEY: stored, **({"type": meaning.layer_type} if meaning.layer_type else {})}

    return _shared(meshes, parameters, held, said, "unit and rule of layer", notes)


def _shared(
    meshes: Sequence[NamedMesh],
    parameters: Sequence[Parameters],
    held: Mapping[str, Holders],
    said: Callable[[Mapping[str, Any]], Dict[str, Any]],
    what: str,
    notes: List[str],
) -> Dict[str, Dict[str, Any]]:
    found = {}
    for name, holders in held.items():
        values = [said(parameters[i].get(holders.name, {})) for i in holders.numbers]
        if values[0] and all(value == values[0] for value in values):
            found[name] = values[0]
        elif any(values):
            names = ", ".join(meshes[i].name for i in holders.numbers)
            notes.append("left out: %s %s, which %s do not have alike" % (what, name, names))
    return found
