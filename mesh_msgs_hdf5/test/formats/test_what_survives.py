"""The table of the README: what of a map is left after a way through each format and back."""
import re
from pathlib import Path

import numpy as np
import pytest

from mesh_msgs_hdf5.checks.check import identical
from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.isolation import isolated
from mesh_msgs_hdf5.labels.map_contents import read_map
from mesh_msgs_hdf5.map_file.scans import ScanFile
from mesh_msgs_hdf5.model.mesh import Features, Label, Materials

from whole_map import write_whole_map

README = Path(__file__).resolve().parents[2] / "README.md"
HEADING = "### What is left after a way there and back"
# column -> what is made of a map, {f}, as a file {o} without a suffix; how it comes back as {n}
WAYS = {
    "PLY": ("export {f} {o}.ply", "import {o}.ply {n}"),
    "OBJ": ("export {f} {o}.obj", "import {o}.obj {n}"),
    "STL": ("export {f} {o}.stl", "import {o}.stl {n}"),
    "DAE": ("export {f} {o}.dae", "import {o}.dae {n}"),
    "GLB": ("export {f} {o}.glb", "import {o}.glb {n}"),
    "glTF": ("export {f} {o}.gltf", "import {o}.gltf {n}"),
    "`convert`": ("convert {f} {o}.h5", "convert {o}.h5 {n}"),
    "`--for lvr2`": ("convert {f} {o}.h5 --for lvr2", "convert {o}.h5 {n}"),
    "`--for both`": ("convert {f} {o}.h5 --for both", "convert {o}.h5 {n}"),
    "`--for ros2`": ("convert {f} {o}.h5 --for ros2", "convert {o}.h5 {n}"),
}


def kept(found, wanted):
    """exact, changed or lost: of a member of a mesh."""
    if wanted is None or found is None:
        return "exact" if found is wanted else "lost"
    if isinstance(wanted, np.ndarray):
        return "exact" if identical(found, wanted) else "changed"
    if isinstance(wanted, (Materials, Features)):
        return worst(kept(value, vars(wanted)[name]) for name, value in vars(found).items())
    if isinstance(wanted, Label):
        return "exact" if np.array_equal(np.sort(found.faces), np.sort(wanted.faces)) else "changed"
    if isinstance(wanted, dict):
        return worst(kept(found[k], v) if k in found else "lost" for k, v in wanted.items())
    return "exact" if found == wanted else "lost"


def worst(all_kept):
    return max(all_kept, key=["exact", "changed", "lost"].index)


def surface(mesh):
    """Its triangles, wherever their corners stand in the list."""
    corners = mesh.vertices[mesh.faces]
    first = np.array([np.lexsort(c.T[::-1])[0] for c in corners])
    turned = [np.roll(c, -f, axis=0) for c, f in zip(corners, first)]
    return np.array(sorted(np.array(turned).reshape(-1, 9).tolist()))


def rows(found, wanted, parts, scans):
    """Row of the table -> what is left of it."""
    same = np.array_equal(surface(found), surface(wanted))
    geometry = worst([kept(found.vertices, wanted.vertices), kept(found.faces, wanted.faces)])
    colors = {text: label.color for text, label in wanted.labels.items()}
    return {
        "triangles": "exact" if same else "changed",
        "numbers of vertices and faces": "exact" if geometry == "exact" else "lost",
        "UUID": "exact" if found.uuid == wanted.uuid else "lost",
        "normals": kept(found.vertex_normals, wanted.vertex_normals),
        "vertex colors": kept(found.vertex_colors, wanted.vertex_colors),
        "layers": kept(found.vertex_costs, wanted.vertex_costs),
        "parameters of layers": kept(found.layer_parameters, wanted.layer_parameters),
        "attributes of vertices": kept(found.vertex_attributes, wanted.vertex_attributes),
        "parameters of vertex attributes": kept(found.vertex_parameters, wanted.vertex_parameters),
        "attributes of faces": kept(found.face_attributes, wanted.face_attributes),
        "parameters of face attributes": kept(found.face_parameters, wanted.face_parameters),
        "textures": kept(found.textures, wanted.textures),
        "texture coordinates": kept(found.texture_coordinates, wanted.texture_coordinates),
        "copies along seams": kept(found.seam_originals, wanted.seam_originals),
        "materials": kept(found.materials, wanted.materials),
        "labels, also in the journal": kept(found.labels, wanted.labels),
        "colors of labels": kept({k: v.color for k, v in found.labels.items()}, colors),
        "features": kept(found.features, wanted.features),
        "frame": kept(found.frame_id, wanted.frame_id),
        "origin": kept(found.origin, wanted.origin),
        "`crs`": kept(found.crs, wanted.crs),
        "scans": scans,
        "other parts": "exact" if "floor_3" in parts else "lost",
    }


def table():
    """Row -> column -> cell, as the README has it."""
    text = README.read_text().split(HEADING)[1]
    lines = [line for line in text.split("\n\n")[2].splitlines() if line.startswith("|")]
    cells = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    return {row[0]: dict(zip(cells[0][1:], row[1:])) for row in cells[2:]}


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ways")
    path = folder / "a.h5"
    write_whole_map(path)
    wanted, _ = read_map(path, "mesh")
    assert "wall_1" in wanted.labels
    result = {}
    for number, (column, (there, back)) in enumerate(WAYS.items()):
        names = {"f": path, "o": folder / ("out%d" % number), "n": folder / ("new%d.h5" % number)}
        for line in (there, back):
            assert main((line.format(**names) + " -q").split()) == 0, line
        parts = isolated("parts", names["n"])
        (scan,), found = ScanFile(path).names(), ScanFile(names["n"])
        points = found.channel(scan) if found.names() else None
        scans = kept(points, ScanFile(path).channel(scan))
        found, _ = read_map(names["n"], "mesh")
        result[column] = rows(found, wanted, parts, scans)
    return result


@pytest.mark.parametrize("way", WAYS)
def test_the_table_says_what_is_left(measured, way):
    assert {row: cells[way] for row, cells in table().items()} == measured[way]
