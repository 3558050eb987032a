"""Which frames may get a parent."""
from mesh_msgs_hdf5.server.origin_frame import FrameTree


def tree(*links):
    found = FrameTree()
    for child, parent, node in links:
        found.add(child, parent, node)
    return found


def test_a_frame_without_a_parent_gets_one_once():
    assert tree().refusal("utm", "map", "/me") == ""
    assert (
        tree(("odom", "map", "/amcl"), ("utm", "earth", "/gps")).refusal("utm", "map", "/me") == ""
    )
    # what it has published itself comes back
    assert tree(("map", "utm", "/me")).refusal("utm", "map", "/me") == ""


def test_never_a_second_parent():
    for links in (
        [("map", "building", "/other")],
        [("/map", "/building", "/other")],
        [("map", "utm", "/me"), ("map", "building", "/other")],
    ):
        why = tree(*links).refusal("utm", "map", "/me")
        assert why == "frame map already has the parent building (from /other)"
    # the same one from another node: both would publish its place
    assert "already has the parent utm" in tree(("map", "utm", "/x")).refusal("utm", "map", "/me")


def test_never_a_circle():
    assert "itself" in tree().refusal("map", "map", "/me")
    links = [("odom", "map", "/a"), ("base", "odom", "/b")]
    assert "in a circle" in tree(*links).refusal("base", "map", "/me")
    # one that is there already is not followed for ever
    links = [("x", "y", "/a"), ("y", "x", "/b")]
    assert tree(*links).refusal("x", "map", "/me") == ""
