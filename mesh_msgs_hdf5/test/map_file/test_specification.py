"""The specification of the map file: it tells of all that is written, and of nothing else."""
import re
from pathlib import Path

import h5py
import numpy as np
import pytest

from mesh_msgs_hdf5.checks.check import MAX_FEATURES
from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.formats.base.images import png
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.map_file.hdf5 import hdf5_guard
from mesh_msgs_hdf5.map_file.reading import material_reader, named_arrays, texture_reader
from mesh_msgs_hdf5.map_file.reading.layouts import S0, S1, S2
from mesh_msgs_hdf5.map_file.scans import ScanFile
from mesh_msgs_hdf5.model import schema
from mesh_msgs_hdf5.model.edit import Edit
from mesh_msgs_hdf5.model.label_names import MAX_LABELS
from mesh_msgs_hdf5.model.mesh import Label

from whole_map import write_whole_map

PAGE = Path(__file__).resolve().parents[3] / "docs/reference/file_format.md"
NUMBERS, FLOATS = "iuf", "f"


def tables(first):
    """The rows of the tables whose first column has this heading."""
    rows, inside = [], False
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip().replace(r"\|", "|") for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        if not cells:
            inside = False
        elif inside:
            rows += [cells] if not set(cells[0]) <= {"-"} else []
        else:
            inside = cells[0] == first
    return rows


def pattern(path):
    return re.compile(re.sub("<[a-z]+>", "[^/]+", path))


OBJECTS = {row[0].strip("`"): row[1:] for row in tables("path")}
LVR2 = {row[0].split(",")[0].strip("`"): row[1:] for row in tables("path, below the part")}
ATTRIBUTES = {(row[0].strip("`"), row[1].strip("`")): row[2:] for row in tables("of")}


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """A map with everything."""
    folder = tmp_path_factory.mktemp("specification")
    path = folder / "map.h5"
    write_whole_map(path)
    map_file = MapFile(path)
    intensity = np.linspace(0, 1, len(map_file.vertices), dtype=np.float32)
    map_file.update(
        Edit(
            vertex_attributes={"intensity": intensity},
            labels={"a free text": Label(np.uint32([0]))},
        )
    )
    picture, poses = folder / "picture.png", folder / "poses.txt"
    picture.write_bytes(png(np.zeros((2, 3, 3), np.uint8)))
    poses.write_text("12.5 0 0 0 0 0 0 1\n")
    camera = dict(images=[str(picture)], intrinsics=(500, 500, 1, 1))
    ScanFile(path).add([str(folder / "cloud.ply")], poses=str(poses), **camera)
    return path


def contents(path):
    """Absolute path -> object, closed with the file."""
    found = {}
    with h5py.File(path, "r") as file:
        file.visititems(lambda name, one: found.setdefault("/" + name, one) and None)
        return {name: described(one) for name, one in found.items()}


def described(one):
    """(dtype, shape; None, None of a group; attributes)."""
    attributes = {name: (one.attrs.get_id(name), one.attrs[name]) for name in one.attrs}
    attributes = {name: (id_.dtype, np.shape(value)) for name, (id_, value) in attributes.items()}
    if isinstance(one, h5py.Group):
        return None, None, attributes
    return one.dtype, one.shape, attributes


def candidates(name):
    """Rows of the specification that an object may be of, by its path; most special first."""
    found = [row for row in OBJECTS if row.startswith("/") and pattern(row).fullmatch(name)]
    return sorted(found, key=lambda row: row.count("<"))


def fits(row_type, dtype, shape, sizes):
    """Whether a type and shape are those of a row: "float32 [V,3]"."""
    if row_type == "group":
        return dtype is None
    kind, _, dimensions = row_type.partition(" ")
    if dtype is None or not same_kind(kind, dtype):
        return False
    for one in re.findall(r"\[([^\]]*)\]", dimensions):
        named = [length(size, sizes) for size in one.split(",")]
        if len(named) == len(shape) and all(
            wanted in (None, found) for wanted, found in zip(named, shape)
        ):
            return True
    return False


def same_kind(kind, dtype):
    if kind == "materials":
        return dtype == schema.MATERIAL_DTYPE
    if kind in ("numbers", "floats"):
        return dtype.kind in (NUMBERS if kind == "numbers" else FLOATS)
    return dtype == np.dtype(kind)


def length(size, sizes):
    """A size such as 3V as a number; None for one that is free."""
    digits, letter = re.fullmatch(r"(\d*)(\w*)", size).groups()
    if not letter:
        return int(digits)
    return int(digits or 1) * sizes[letter] if letter in sizes else None


def sizes_of(found, name):
    part = "/" + name.split("/")[1]
    shapes = [found.get(part + "/channels/" + one) for one in (schema.VERTICES, schema.FACES)]
    return {letter: one[1][0] for letter, one in zip("VF", shapes) if one}


def row_of(found, name):
    """The row of an object; an attribute of vertices is told from a layer by its mark or type."""
    dtype, shape, attributes = found[name]
    rows = candidates(name)
    if "kind" in attributes:
        rows = [row for row in rows if not row.endswith("<layer>")]
    sizes = sizes_of(found, name)
    return next((row for row in rows if fits(OBJECTS[row][0], dtype, shape, sizes)), None)


def test_everything_in_a_map_is_specified(path):
    found = contents(path)
    rows = {name: row_of(found, name) for name in found}
    assert {name: found[name][:2] for name, row in rows.items() if row is None} == {}
    unknown = [
        (name, attribute)
        for name, (_, _, attributes) in found.items()
        for attribute in attributes
        if (rows[name], attribute) not in ATTRIBUTES
    ]
    assert unknown == []


def test_everything_specified_is_in_a_map(path):
    found = contents(path)
    used = {row_of(found, name) for name in found}
    assert {row for row in OBJECTS if row.startswith("/")} - used == set()
    attributes = {(row_of(found, name), one) for name in found for one in found[name][2]}
    assert set(ATTRIBUTES) - attributes == set()


def test_what_is_always_there_is(path):
    """In each object of its kind, or in the group above it."""
    found = contents(path)
    for row, (_, needed, _) in OBJECTS.items():
        above = row.rpartition("/")[0]
        if needed == "always" and above:
            for name in found:
                if row_of(found, name) == above:
                    assert any(row_of(found, one) == row for one in found if one.startswith(name))
    for (row, attribute), (_, needed, _) in ATTRIBUTES.items():
        if needed == "always":
            owners = [name for name in found if row_of(found, name) == row]
            assert owners and all(attribute in found[name][2] for name in owners)


def test_types_of_attributes(path):
    found = contents(path)
    for name, (_, _, attributes) in found.items():
        for attribute, (dtype, shape) in attributes.items():
            kind = ATTRIBUTES[row_of(found, name), attribute][0]
            if kind == "text":
                assert dtype.kind in "SO" and shape == ()
            else:
                wanted, _, dimensions = kind.partition(" ")
                assert dtype == np.dtype(wanted)
                assert shape == ((3,) if dimensions else ())


@pytest.mark.parametrize("whom, groups", [("lvr2", "channels"), ("ros2", "geometry")])
def test_lvr2s_form_of_textures(path, tmp_path, whom, groups):
    out = tmp_path / "out.h5"
    assert main(["convert", str(path), str(out), "--for", whom, "-q"]) == 0
    found = contents(out)
    for row, (kind, _) in LVR2.items():
        name = "/mesh/" + row.replace("channels", groups).replace("<index>", "0")
        sizes = {"V": 38, "F": 48}
        assert fits(kind, *found[name][:2], sizes), name


def test_places_of_other_schemas():
    """The table has the places that the layouts have, and no others."""
    rows = {row[0]: row[1:] for row in tables("")}
    for column, layout in enumerate((S0, S1, S2)):
        for name, places in (
            ("vertices", [layout.vertices]),
            ("faces", [layout.faces]),
            ("normals", layout.normals),
            ("colors", layout.colors),
            ("layers, vertex attributes", layout.layers),
            ("features", [layout.features]),
            ("texture coordinates", layout.texture_coordinates),
            (
                "face attributes",
                [one for one in (layout.face_attributes, *layout.face_arrays) if one],
            ),
        ):
            assert re.findall("`([^`]+)`", rows[name][column]) == list(places), (
                name,
                layout.schema,
            )


def test_limits_and_versions():
    limits = dict(tables("limit"))
    numbers = {
        name: int(text.replace(",", "").replace("2^20", str(2**20)))
        for name, text in limits.items()
        if re.fullmatch(r"[\d,^]+", text)
    }
    assert numbers == {
        "labels": MAX_LABELS,
        "entries in any listed group": hdf5_guard.MAX_CHILDREN,
        "layers and vertex attributes, face attributes": named_arrays.MAX_ARRAYS,
        "features": MAX_FEATURES,
        "textures": texture_reader.MAX_TEXTURES,
        "materials": material_reader.MAX_MATERIALS,
    }
    text = PAGE.read_text(encoding="utf-8")
    assert "Version %d of the format" % schema.VERSION in text
    kept = text.split("are kept for mesh data:")[1].split("all that ends")[0]
    assert set(re.findall("`([^`]+)`", kept)) >= schema.RESERVED - {"edge_distances_idx"}
