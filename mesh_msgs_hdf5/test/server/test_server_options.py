"""The parameters of hdf5_map_server."""
import genpy
import pytest

from mesh_msgs_hdf5.label_manager.label_manager_options import parse as parse_labels
from mesh_msgs_hdf5.model.errors import MapFileError
from mesh_msgs_hdf5.server.map_loading import load
from mesh_msgs_hdf5.server.server_options import ALL_PARTS, MapRequest, ServerOptions, parse


@pytest.mark.parametrize(
    "parameters, maps",
    [
        ({}, [("/tmp/map.h5", None)]),
        ({"inputFile": "/a.h5"}, [("/a.h5", None)]),
        ({"inputFile": 5, "mesh_part": 7}, [("/folder/5", "7")]),
        ({"inputFile": "b.h5", "mesh_part": "mesh"}, [("/folder/b.h5", "mesh")]),
        ({"inputFile": "/a.h5", "mesh_part": ""}, [("/a.h5", ALL_PARTS)]),
        ({"inputFile": "/a.h5", "mesh_part": "/"}, [("/a.h5", "/")]),
        ({"inputFile": "/a.h5", "mesh_part": ["x", "y"]}, [("/a.h5", "x"), ("/a.h5", "y")]),
        ({"inputFile": "/a.h5", "mesh_part": []}, [("/a.h5", None)]),
        ({"inputFile": ["/a.h5", "/b.h5", "/a.h5"]}, [("/a.h5", None), ("/b.h5", None)]),
        ({"maps": [{"file": "/a.h5"}]}, [("/a.h5", None)]),
        (
            {"maps": [{"file": "/a.h5", "part": ["x", ""]}], "inputFile": "/b.h5"},
            [("/a.h5", "x"), ("/a.h5", ALL_PARTS), ("/b.h5", None)],
        ),
        ({"maps": [], "somebody_elses": object()}, [("/tmp/map.h5", None)]),
    ],
)
def test_maps(parameters, maps, monkeypatch):
    monkeypatch.setattr("os.getcwd", lambda: "/folder")
    assert parse(parameters) == ServerOptions([MapRequest(*map) for map in maps], False, 2.0)


def test_files_as_arguments(monkeypatch):
    monkeypatch.setattr("os.getcwd", lambda: "/folder")
    options = parse({"inputFile": "/c.h5", "mesh_part": "x"}, ["/a.h5", "b [1]: #.ply"])
    assert options.maps == [MapRequest("/a.h5", "x"), MapRequest("/folder/b [1]: #.ply", "x")]
    with pytest.raises(ValueError, match="no option --fast"):
        parse({}, ["/a.h5", "--fast"])


def test_the_frame_of_origins():
    assert parse({}).origin_frame == ""
    assert parse({"origin_frame": "utm_32"}).origin_frame == "utm_32"
    for wrong in (5, "/utm", "a\nb", ["utm"]):
        with pytest.raises(ValueError, match="~origin_frame is "):
            parse({"origin_frame": wrong})


def test_the_others():
    options = parse({"read_only": True, "save_delay": 0})
    assert (options.read_only, options.save_delay) == (True, 0.0)


@pytest.mark.parametrize(
    "parameters, words",
    [
        ({"inputFile": ""}, "~inputFile is ''"),
        ({"inputFile": {"a": 1}}, "~inputFile is {'a': 1}"),
        ({"inputFile": []}, r"~inputFile is \[\]"),
        ({"inputFile": ["/a", None]}, "~inputFile is None"),
        ({"inputFile": "a\0b"}, "~inputFile"),
        ({"inputFile": True}, "~inputFile is True"),
        ({"mesh_part": {"a": 1}}, "~mesh_part is {'a': 1}"),
        ({"mesh_part": [False]}, r"~mesh_part is \[False\]"),
        ({"maps": "/a.h5"}, "~maps is '/a.h5'; give a list"),
        ({"maps": ["/a.h5"]}, r"~maps\[0\] is '/a.h5'"),
        ({"maps": [{"file": "/a"}, {"part": "x"}]}, r"~maps\[1\]"),
        ({"maps": [{"file": "/a", "name": "x"}]}, r"~maps\[0\]"),
        ({"maps": [{"file": 1.5}, {"file": ""}]}, r"~maps\[1\].file is ''"),
        ({"read_only": "yes"}, "~read_only is 'yes'"),
        ({"save_delay": -1}, "~save_delay is -1"),
        ({"save_delay": float("nan")}, "~save_delay is nan"),
        ({"save_delay": "2"}, "~save_delay is '2'"),
        ({"save_delay": True}, "~save_delay is True"),
        ({"save_delay": 1e9}, "~save_delay"),
    ],
)
def test_what_cannot_be_meant_is_one_sentence(parameters, words):
    with pytest.raises(ValueError, match=words) as refused:
        parse(parameters)
    assert "\n" not in str(refused.value) and ";" in str(refused.value)


def test_a_relative_path_to_nothing_says_where_nodes_run(tmp_path, monkeypatch):
    """With roslaunch that is ~/.ros, which nobody thinks of."""
    monkeypatch.chdir(tmp_path)
    for options in (
        parse({"inputFile": "maps/garden.h5"}),
        parse({"maps": [{"file": "maps/garden.h5"}]}),
        parse({}, ["maps/garden.h5"]),
    ):
        with pytest.raises(MapFileError) as refused:
            load(options.maps[0], genpy.Time(1), {}, True)
        text = str(refused.value)
        assert text.startswith("maps/garden.h5: there is no such file (nodes run in %s," % tmp_path)
        assert "give an absolute path" in text
    with pytest.raises(MapFileError) as refused:
        load(MapRequest(str(tmp_path / "a.h5")), genpy.Time(1), {}, True)
    assert "nodes run" not in str(refused.value)


def test_so_does_label_manager(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(MapFileError, match="maps/a.h5: .*nodes run in"):
        options = parse_labels({"map_file": "maps/a.h5", "folder_path": "labels"})
        options.check(options.maps[0])
