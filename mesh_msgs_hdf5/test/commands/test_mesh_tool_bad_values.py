"""Every verb of mesh_tool does what it can on a map in which one thing is bad, and says what is."""
import json
import re

import pytest
from bad_values import BAD, write_bad

from mesh_msgs_hdf5.commands.mesh_tool import main
from mesh_msgs_hdf5.map_file import MapFile
from mesh_msgs_hdf5.validation.validate import validate

pytestmark = pytest.mark.usefixtures("read_here")
# what a verb does not look at; what has no place in its answer
UNREAD = {
    "info": {"normal", "no normals", "alpha", "link"},
    "layers": set(BAD) - {"layer", "wide layer", "layer name", "parameters"},
    "labels": {kind for kind in BAD if not kind.startswith("label") and kind != "vertices"},
    "render": set(BAD) - {"vertices", "texture", "materials", "coordinates"},
}
# {f}: the map, {o}: a new file without a suffix
VERBS = {
    "info": "info {f}",
    "export ply": "export {f} {o}.ply",
    "export glb": "export {f} {o}.glb",
    "convert": "convert {f} {o}.h5",
    "import": "import {f} {o}.h5",
    "import --repair": "import {f} {o}.h5 --repair",
    "repair": "repair {f} {o}.h5",
    "diff": "diff {f} {f}",
    "layers": "layers list {f}",
    "labels": "labels list {f}",
    "render": "render {f} {o}.png --size 200x200",
}
CHANGING = [
    "labels delete {f} tree_2",
    "labels rename {f} tree_1 tree_7",
    "labels delete {f} --class tree",
    "layers copy {f} height_diff new",
    "layers rename {f} height_diff new",
    "repack {f}",
    "repair {f}",
]


def some_of(lines, kind, count):
    """So many of them, others for the next kind: all read maps in one way, so that not each of them
    has to meet each kind."""
    start = list(BAD).index(kind) * count
    return [lines[(start + i) % len(lines)] for i in range(count)]


def said(capsys, line):
    """(exit code, answer) of a command."""
    code = main(line.split() + ["--json"])
    output = capsys.readouterr()
    return code, json.loads(output.out) if output.out else output.err


@pytest.mark.parametrize("kind", BAD)
def test_every_verb(tmp_path, rich_data, capsys, kind):
    path = tmp_path / "a.h5"
    write_bad(path, rich_data, kind)
    before = path.read_bytes()
    chosen = [*some_of(list(VERBS), kind, 5), "repair"]
    for name in dict.fromkeys(chosen):
        line = VERBS[name]
        out = tmp_path / re.sub("[^a-z0-9]", "_", name)
        code, answer = said(capsys, line.format(f=path, o=out))
        differs = name == "diff" and kind == "texture"  # what cannot be read is not the same
        assert (name, code) == (name, int(differs)), answer
        notes = "\n".join(answer["notes"] + [one["text"] for one in answer.get("differences", ())])
        looked_at = kind not in UNREAD.get(name.split()[0], ())
        assert bool(re.search(BAD[kind].words, notes)) == looked_at, (name, notes)
    assert path.read_bytes() == before
    for new in tmp_path.glob("[!a]*.h5"):
        errors = [f for f in validate(str(new)) if f.level == "error"]
        # a name that is no text stays in the file, with all else that is unknown
        assert not errors or (kind == "label of no text" and "UTF-8" in errors[0].message), errors
        assert MapFile(new).read().uuid


@pytest.mark.parametrize("kind", BAD)
def test_verbs_that_change_the_map(tmp_path, rich_data, capsys, kind):
    path = tmp_path / "a.h5"
    for line in dict.fromkeys([*some_of(CHANGING, kind, 2), "repair {f}"]):
        write_bad(path, rich_data, kind)
        code, answer = said(capsys, line.format(f=path))
        assert (line, code) == (line, 0), answer
        file = MapFile(path)
        file.read()
        if line.startswith("repair") and kind != "label of no text":
            assert file.notes == [] and re.search(BAD[kind].words, "\n".join(answer["notes"]))
        if line == "labels delete {f} tree_2":
            assert "tree_2" not in file.label_names()


def test_repairing_a_sound_map_does_not_touch_it(tmp_path, rich_mesh, capsys):
    path = tmp_path / "a.h5"
    MapFile.write(path, rich_mesh)
    before = path.stat()
    assert main(["repair", str(path)]) == 0
    assert "nothing is wrong with it" in capsys.readouterr().out
    assert (path.stat().st_ino, path.stat().st_mtime_ns) == (before.st_ino, before.st_mtime_ns)


def test_a_label_that_cannot_be_read_can_only_be_deleted(tmp_path, rich_data, capsys):
    path = tmp_path / "a.h5"
    write_bad(path, rich_data, "label type")
    for line in ("labels rename {f} tree_2 tree_9", "labels color {f} #000000 tree_2"):
        assert main(line.format(f=path).split()) == 1
        assert "label 'tree_2' cannot be read" in capsys.readouterr().err
    assert main(["labels", "delete", str(path), "tree_2"]) == 0


def test_only_maps_of_our_schema_are_repaired_in_place(tmp_path, rich_mesh, capsys):
    from map_samples import write_s2

    path = tmp_path / "a.h5"
    write_s2(path, rich_mesh)
    before = path.read_bytes()
    assert main(["repair", str(path)]) == 1
    assert "schema S2" in capsys.readouterr().err and path.read_bytes() == before
    assert main(["repair", str(path), str(tmp_path / "b.h5")]) == 0
    assert MapFile(tmp_path / "b.h5").schema == "S1"
