"""The Move Base Flex interface V04 on the wire: md5 sums, order of fields, constants."""

import subprocess

import pytest
import rosmsg

from mbf_msgs import msg, srv

MESSAGE_MD5 = {
    "GetPathAction": "f4d6567e6c5805b81da135676625d187",
    "GetPathGoal": "301d9f5ec2f8f08d1d4e16663a6d2c5a",
    "GetPathActionGoal": "d557bc13deb1742d682c0788c70012fa",
    "GetPathResult": "b737d51aec954f878a4cd57e83f5767c",
    "GetPathActionResult": "b591e970edf53cd68b6436930a31222a",
    "GetPathFeedback": "d41d8cd98f00b204e9800998ecf8427e",
    "GetPathActionFeedback": "aae20e09065c3809e8a8e87c4c8953fd",
    "ExePathAction": "1eb3204035d1ceb85b999c9c0a477f7b",
    "ExePathGoal": "997d05ac3260fea4e2e2586ca47d2578",
    "ExePathActionGoal": "2e906bfb25f223a7c3bdf127e99a7e16",
    "ExePathResult": "b22f308686bb4e3a7364ea944ef68fd0",
    "ExePathActionResult": "c0c371e6e71c834fcf0eea1b2ae047b5",
    "ExePathFeedback": "1b30e381361670e9521046df439847e2",
    "ExePathActionFeedback": "41e5119fe263f5296a0eba2eff692cd2",
    "MoveBaseAction": "c98ceb3d38dd07397b09c7280aa0d553",
    "MoveBaseGoal": "722601faf59588c53b718bb090b96808",
    "MoveBaseActionGoal": "2536b6e0a889940672a086994f497615",
    "MoveBaseResult": "c65d301ffa20590244253c6a99c37c5e",
    "MoveBaseActionResult": "3ba171ea938c4125488c9249510c56e0",
    "MoveBaseFeedback": "1b30e381361670e9521046df439847e2",
    "MoveBaseActionFeedback": "41e5119fe263f5296a0eba2eff692cd2",
    "RecoveryAction": "b35ffa9c1783e3d612414d87fbc80598",
    "RecoveryGoal": "ce28884316a172b85e57b78a84014451",
    "RecoveryActionGoal": "3a9f8ac70c8c2835fd7b695b2437b7ef",
    "RecoveryResult": "41d522f528f315af4a6c19e2fde7a3d0",
    "RecoveryActionResult": "cae6c01476f7c64808fc85f9972a982e",
    "RecoveryFeedback": "d41d8cd98f00b204e9800998ecf8427e",
    "RecoveryActionFeedback": "aae20e09065c3809e8a8e87c4c8953fd",
}
SERVICE_MD5 = {  # service, request, response
    "CheckPose": (
        "540ccc67006cf1c2c5502427e26c7f21",
        "265e0591fcb39074b9d918fb13f423f4",
        "d74139e1f7169aa4fb64b44c3a698692",
    ),
    "CheckPath": (
        "59ef27f5ce7e3cc3c7f7a0f823bca55c",
        "16f70020b17f5c034724ed8fb518b9f5",
        "420eb6a13d128bba3770710452ea1c17",
    ),
    "CheckPoint": (
        "098ffffe56a4f2f59d33aa09df0749c1",
        "36e9c2f425eee0a2ebd8c4b0aae9f573",
        "d74139e1f7169aa4fb64b44c3a698692",
    ),
}

FEEDBACK_WHILE_DRIVING = [
    ("outcome", "uint32"),
    ("message", "string"),
    ("dist_to_goal", "float32"),
    ("angle_to_goal", "float32"),
    ("current_pose", "geometry_msgs/PoseStamped"),
    ("last_cmd_vel", "geometry_msgs/TwistStamped"),
]
CHECK_FACTORS = [
    ("safety_dist", "float32"),
    ("lethal_cost_mult", "float32"),
    ("inscrib_cost_mult", "float32"),
    ("unknown_cost_mult", "float32"),
    ("costmap", "uint8"),
]
FIELDS = {
    msg.GetPathGoal: [
        ("use_start_pose", "bool"),
        ("start_pose", "geometry_msgs/PoseStamped"),
        ("target_pose", "geometry_msgs/PoseStamped"),
        ("tolerance", "float64"),
        ("planner", "string"),
        ("concurrency_slot", "uint8"),
    ],
    msg.GetPathResult: [
        ("outcome", "uint32"),
        ("message", "string"),
        ("path", "nav_msgs/Path"),
        ("cost", "float64"),
    ],
    msg.GetPathFeedback: [],
    msg.ExePathGoal: [
        ("path", "nav_msgs/Path"),
        ("controller", "string"),
        ("concurrency_slot", "uint8"),
        ("tolerance_from_action", "bool"),
        ("dist_tolerance", "float32"),
        ("angle_tolerance", "float32"),
    ],
    msg.ExePathResult: [
        ("outcome", "uint32"),
        ("message", "string"),
        ("final_pose", "geometry_msgs/PoseStamped"),
        ("dist_to_goal", "float32"),
        ("angle_to_goal", "float32"),
    ],
    msg.ExePathFeedback: FEEDBACK_WHILE_DRIVING,
    msg.MoveBaseGoal: [
        ("target_pose", "geometry_msgs/PoseStamped"),
        ("controller", "string"),
        ("planner", "string"),
        ("recovery_behaviors", "string[]"),
    ],
    msg.MoveBaseResult: [
        ("outcome", "uint32"),
        ("message", "string"),
        ("dist_to_goal", "float32"),
        ("angle_to_goal", "float32"),
        ("final_pose", "geometry_msgs/PoseStamped"),
    ],
    msg.MoveBaseFeedback: FEEDBACK_WHILE_DRIVING,
    msg.RecoveryGoal: [("behavior", "string"), ("concurrency_slot", "uint8")],
    msg.RecoveryResult: [("outcome", "uint32"), ("message", "string"), ("used_plugin", "string")],
    msg.RecoveryFeedback: [],
    srv.CheckPointRequest: [("point", "geometry_msgs/PointStamped"), ("costmap", "uint8")],
    srv.CheckPointResponse: [("state", "uint8"), ("cost", "uint32")],
    srv.CheckPoseRequest: [
        ("pose", "geometry_msgs/PoseStamped"),
        *CHECK_FACTORS,
        ("current_pose", "bool"),
    ],
    srv.CheckPoseResponse: [("state", "uint8"), ("cost", "uint32")],
    srv.CheckPathRequest: [
        ("path", "nav_msgs/Path"),
        *CHECK_FACTORS,
        ("return_on", "uint8"),
        ("skip_poses", "uint8"),
        ("path_cells_only", "bool"),
    ],
    srv.CheckPathResponse: [("last_checked", "uint32"), ("state", "uint8"), ("cost", "uint32")],
}


def numbered(first, names):
    """SUCCESS 0, then the names one after the other from ``first`` on."""
    return {"SUCCESS": 0, **{name: first + i for i, name in enumerate(names.split())}}


COSTMAPS = {"LOCAL_COSTMAP": 1, "GLOBAL_COSTMAP": 2}
STATES = {"FREE": 0, "INSCRIBED": 1, "LETHAL": 2, "UNKNOWN": 3, "OUTSIDE": 4}
CONSTANTS = {
    msg.GetPathResult: numbered(
        50,
        "FAILURE CANCELED INVALID_START INVALID_GOAL NO_PATH_FOUND PAT_EXCEEDED EMPTY_PATH TF_ERROR"
        " NOT_INITIALIZED INVALID_PLUGIN INTERNAL_ERROR OUT_OF_MAP MAP_ERROR STOPPED",
    ),
    msg.ExePathResult: numbered(
        100,
        "FAILURE CANCELED NO_VALID_CMD PAT_EXCEEDED COLLISION OSCILLATION ROBOT_STUCK MISSED_GOAL"
        " MISSED_PATH BLOCKED_PATH INVALID_PATH TF_ERROR NOT_INITIALIZED INVALID_PLUGIN"
        " INTERNAL_ERROR OUT_OF_MAP MAP_ERROR STOPPED",
    ),
    msg.MoveBaseResult: {
        **numbered(
            10,
            "FAILURE CANCELED COLLISION OSCILLATION START_BLOCKED GOAL_BLOCKED TF_ERROR"
            " INTERNAL_ERROR",
        ),
        "PLAN_FAILURE": 50,
        "CTRL_FAILURE": 100,
    },
    msg.RecoveryResult: numbered(
        150,
        "FAILURE CANCELED PAT_EXCEEDED TF_ERROR NOT_INITIALIZED INVALID_PLUGIN INTERNAL_ERROR"
        " STOPPED IMPASSABLE",
    ),
    srv.CheckPointRequest: COSTMAPS,
    srv.CheckPointResponse: STATES,
    srv.CheckPoseRequest: COSTMAPS,
    srv.CheckPoseResponse: STATES,
    srv.CheckPathRequest: COSTMAPS,
    srv.CheckPathResponse: STATES,
}


def output_of(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


@pytest.mark.parametrize("name", MESSAGE_MD5)
def test_md5_of_message_class(name):
    assert getattr(msg, name)._md5sum == MESSAGE_MD5[name]


@pytest.mark.parametrize("name", SERVICE_MD5)
def test_md5_of_service_classes(name):
    service = getattr(srv, name)
    classes = (service, service._request_class, service._response_class)
    assert tuple(cls._md5sum for cls in classes) == SERVICE_MD5[name]


def types_listed_by(command):
    """Types of mbf_msgs that ``rosmsg list`` or ``rossrv list`` knows."""
    return {line for line in output_of(command, "list").split() if line.startswith("mbf_msgs/")}


def test_rosmsg_knows_every_type_with_its_md5():
    assert types_listed_by("rosmsg") == {f"mbf_msgs/{name}" for name in MESSAGE_MD5}
    for name, md5 in MESSAGE_MD5.items():
        assert rosmsg.rosmsg_md5(rosmsg.MODE_MSG, f"mbf_msgs/{name}") == md5, name


def test_rossrv_knows_every_type_with_its_md5():
    assert types_listed_by("rossrv") == {f"mbf_msgs/{name}" for name in SERVICE_MD5}
    for name, (md5, _, _) in SERVICE_MD5.items():
        assert rosmsg.rosmsg_md5(rosmsg.MODE_SRV, f"mbf_msgs/{name}") == md5, name


@pytest.mark.parametrize("cls", FIELDS, ids=lambda cls: cls.__name__)
def test_order_and_types_of_fields(cls):
    assert list(zip(cls.__slots__, cls._slot_types)) == FIELDS[cls]


@pytest.mark.parametrize("cls", FIELDS, ids=lambda cls: cls.__name__)
def test_constants(cls):
    found = {name: getattr(cls, name) for name in vars(cls) if name.isupper()}
    assert found == CONSTANTS.get(cls, {})
