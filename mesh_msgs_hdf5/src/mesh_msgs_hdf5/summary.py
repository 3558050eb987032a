"""What is in a mesh file, as plain values."""
import os
from typing import Any, Dict

import numpy as np

from mesh_msgs_hdf5.importer import read_mesh
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.probe import kind_of, read_head


def summarize(path: str, part: str = "mesh") -> Dict[str, Any]:
    """What a file holds: counts, bounds in meters, layers, frame, UUID, parts, provenance.

    Reads and checks all of it. The result is made of dicts, lists, texts and numbers. Raises
    MapFileError.
    """
    summary: Dict[str, Any] = {"path": os.fsdecode(path)}
    mesh, report = read_mesh(path, part)
    summary.update(format=report.format, file_bytes=os.stat(path).st_size)
    if kind_of(path, read_head(path)) == "h5":
        file = MapFile(path, part)
        summary.update(
            schema="S1",
            schema_version=file.schema_version,
            part=part,
            parts=file.parts,
            uuid=file.uuid,
            other_contents=file.other_contents(),
        )
    else:
        summary.update(uuid=mesh.uuid, notes=report.notes)
    summary.update(
        frame_id=mesh.frame_id,
        vertices=len(mesh.vertices),
        faces=len(mesh.faces),
        bounds={
            "min": mesh.vertices.min(axis=0).tolist(),
            "max": mesh.vertices.max(axis=0).tolist(),
        },
        normals=mesh.vertex_normals is not None,
        colors=mesh.vertex_colors is not None,
        layers=[
            dict(costs_summary(costs), name=name, parameters=mesh.layer_parameters.get(name, {}))
            for name, costs in mesh.vertex_costs.items()
        ],
        source=mesh.source,
    )
    return summary


def costs_summary(costs: np.ndarray) -> Dict[str, Any]:
    """Range of the finite values, and counts of lethal, unknown and negative ones.

    min and max are None if no value is finite.
    """
    finite = costs[np.isfinite(costs)]
    return {
        "min": float(finite.min()) if len(finite) else None,
        "max": float(finite.max()) if len(finite) else None,
        "lethal": int(np.count_nonzero(costs == np.inf)),
        "unknown": int(np.count_nonzero(np.isnan(costs))),
        "negative": int(np.count_nonzero(costs < 0)),
    }
