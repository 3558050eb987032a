"""Changes of a map on top of each other, against a model that makes them one after the other."""
import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mesh_msgs_hdf5.model.edit import Edit, is_empty
from mesh_msgs_hdf5.server.map_overlay import merged, without

# objects of their own, as arrays are: what counts is which one it is
VALUES = st.builds(object)
SINGLE = ("vertex_normals", "vertex_colors", "texture_coordinates", "materials", "features")


def dictionaries(keys):
    return st.dictionaries(st.sampled_from(keys), st.none() | VALUES, max_size=3)


@st.composite
def edits(draw):
    removed = draw(st.frozensets(st.sampled_from(SINGLE), max_size=2))
    values = {name: draw(st.none() | VALUES) for name in SINGLE if name not in removed}
    costs, faces = draw(dictionaries("abc")), draw(dictionaries("xyz"))
    return Edit(
        vertex_costs=costs,
        layer_parameters={k: draw(VALUES) for k, v in costs.items() if v and draw(st.booleans())},
        face_attributes=faces,
        face_parameters={k: draw(VALUES) for k, v in faces.items() if v and draw(st.booleans())},
        textures=draw(dictionaries([0, 1])),
        labels=draw(dictionaries(["tree_1"])),
        frame_id=draw(st.none() | VALUES),
        remove=removed,
        **values,
    )


def applied(state, edit):
    """What is in a file after the change: member or (member, key) -> value."""
    state = dict(state)
    for name, value in vars(edit).items():
        if isinstance(value, dict):
            for key, item in value.items():
                state[name, key] = item
        elif name != "remove" and value is not None:
            state[name] = value
    for name in edit.remove:
        state[name] = None
    for costs, parameters in (
        ("vertex_costs", "layer_parameters"),
        ("face_attributes", "face_parameters"),
    ):
        for key in set(getattr(edit, costs)) - set(getattr(edit, parameters)):
            state[parameters, key] = None
    return {key: value for key, value in state.items() if value is not None}


@given(st.lists(edits(), max_size=4))
def test_merged_does_what_one_after_the_other_does(changes):
    expected, whole = {}, Edit()
    for change in changes:
        expected, whole = applied(expected, change), merged(whole, change)
    assert applied({}, whole) == expected


@given(edits(), edits(), edits())
def test_what_is_saved_is_forgotten_but_nothing_later(first, second, third):
    """Saving a snapshot, then what is left, is the same as saving everything at the end."""
    snapshot = merged(first, second)
    now = merged(snapshot, third)
    left = without(now, snapshot)
    assert applied(applied({}, snapshot), left) == applied({}, now)


@given(edits())
def test_nothing_is_left_of_what_is_saved_whole(edit):
    assert is_empty(without(edit, edit))
    assert is_empty(merged(Edit(), Edit()))


@given(edits(), edits())
def test_edits_are_not_modified(first, second):
    before = [dataclasses.replace(edit) for edit in (first, second)]
    tables = [{k: dict(v) for k, v in vars(e).items() if isinstance(v, dict)} for e in before]
    without(merged(first, second), first)
    assert [first, second] == before
    for edit, table in zip((first, second), tables):
        for name, content in table.items():
            assert getattr(edit, name) == content


@pytest.mark.parametrize(
    "edit", [Edit(textures={0: None}), Edit(frame_id="a"), Edit(remove=frozenset({"features"}))]
)
def test_any_change_is_not_empty(edit):
    assert not is_empty(edit)
