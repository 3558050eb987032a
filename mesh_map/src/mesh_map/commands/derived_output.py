"""A mesh that was derived of another one, saved with all that belongs to it."""

import argparse
from dataclasses import replace
from typing import Any, Callable, List, Mapping, Optional

from mesh_msgs.derived_mesh import DerivedMesh
from mesh_msgs_hdf5.commands._common import add_part, say
from mesh_msgs_hdf5.commands.map_output import (
    add_map_output,
    check_map_output,
    save_map,
    saved_line,
    saved_value,
)
from mesh_msgs_hdf5.model.carried_mesh import carried_mesh, carried_parameters
from mesh_msgs_hdf5.model.mesh import Mesh
from mesh_msgs_hdf5.model.seams import split_mesh

from mesh_map.geometry.seams import derived_with_copies


def add_in_and_out(parser: argparse.ArgumentParser) -> None:
    """The arguments IN and OUT.h5, and the options of verbs that make a map file of a mesh."""
    parser.add_argument("input", metavar="IN", help="a map file, or any mesh that import reads")
    parser.add_argument("output", metavar="OUT.h5", help="the map file to make")
    add_part(parser, "IN, if it is a map with several")
    add_map_output(parser)


def check_in_and_out(arguments: argparse.Namespace) -> None:
    """Refuse early what cannot be saved; IN may be OUT.h5 where a mesh of it is to be made."""
    check_map_output(arguments, None if arguments.to_part is not None else arguments.input)


def carried(
    mesh: Mesh,
    derive: Callable[..., Optional[DerivedMesh]],
    kind: str,
    parameters: Mapping[str, Any],
) -> Optional[Mesh]:
    """All that a mesh has, on one that is derived of it; its source says how that was made.

    derive: makes it of the vertices and faces without copies along seams, and the parent_uuid; None
    is nothing to be done, and is returned.
    """
    uuid = mesh.parent_uuid or mesh.uuid
    derived = derive(mesh.parent_vertices, mesh.parent_faces, parent_uuid=uuid)
    if derived is None:
        return None
    split = split_mesh(mesh, mesh.uuid)
    if split is None:
        result = carried_mesh(mesh, derived)
    else:
        originals, of_split = derived_with_copies(split, derived)
        result = carried_mesh(mesh, of_split)
        result = replace(result, seam_originals=originals if len(originals) else None)
    return _with_source(result, mesh, derived, kind, parameters)


def carried_to(mesh: Mesh, derived: DerivedMesh, kind: str, parameters: Mapping[str, Any]) -> Mesh:
    """carried() to a mesh that was derived of this one with its copies along seams; which of the
    vertices are copies then is left to the caller."""
    return _with_source(carried_mesh(mesh, derived), mesh, derived, kind, parameters)


def _with_source(
    result: Mesh, mesh: Mesh, derived: DerivedMesh, kind: str, parameters: Mapping[str, Any]
) -> Mesh:
    result.layer_parameters = carried_parameters(result.vertex_costs, mesh.layer_parameters, kind)
    result.source = {
        "derived": kind,
        "parameters": dict(parameters),
        "parent_uuid": derived.parent_uuid,
        "before": mesh.source,
    }
    return result


def interpolated_layers(mesh: Mesh) -> List[str]:
    """Notes for people: of the layers that a derived mesh has."""
    if not mesh.vertex_costs:
        return []
    names = ", ".join(sorted(mesh.vertex_costs))
    return ["interpolated, so mesh_map computes them anew: layers %s" % names]


def saved(
    arguments: argparse.Namespace,
    mesh: Mesh,
    notes: List[str],
    head: str,
    more: Optional[Mapping[str, Any]] = None,
) -> int:
    """Save the mesh, and say so; returns the exit code. head: what was done, for people; more: the
    same for programs."""
    notes = notes + save_map(arguments, mesh)
    value = {
        "input": arguments.input,
        "notes": notes,
        **(more or {}),
        **saved_value(arguments, mesh),
    }
    lines = [head, *("  note: " + note for note in notes), saved_line(value)]
    say(arguments, value, lines)
    return 0
