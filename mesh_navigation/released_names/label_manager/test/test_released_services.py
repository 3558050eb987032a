"""What programs import by the released names, and what is the same on the wire."""
import subprocess

import mesh_msgs.srv
import pytest

import label_manager.srv

RELEASED = {
    "DeleteLabel": "291f4a1190a82bb2a4fa8742276ac1a4",
    "GetLabelGroups": "83c83c156bee06ca7fa5eef7a0fc9203",
    "GetLabeledClusterGroup": "ca761f9c98d5f0693e9369657698d5a9",
}


@pytest.mark.parametrize("name", RELEASED)
def test_a_service_has_the_released_name_and_sum(name):
    released, ours = (getattr(module, name) for module in (label_manager.srv, mesh_msgs.srv))
    assert released._type == "label_manager/" + name
    assert released._md5sum == ours._md5sum == RELEASED[name]
    for half in ("_request_class", "_response_class"):
        one, other = getattr(released, half), getattr(ours, half)
        assert one._md5sum == other._md5sum and one.__slots__ == other.__slots__


def test_the_node_is_found():
    help_text = subprocess.run(
        ["rosrun", "label_manager", "label_manager", "--help"],
        stdout=subprocess.PIPE,
        universal_newlines=True,
        check=True,
    ).stdout
    assert "Node label_manager" in help_text
