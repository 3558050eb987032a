"""mesh_tool scans: the scans that a map was made of, with their poses and images."""
import argparse
import os
import sys
from typing import Any, Dict, List

from mesh_msgs.text import one_line
from mesh_msgs_hdf5.commands._common import add_actions, say
from mesh_msgs_hdf5.commands.progress import ProgressLine
from mesh_msgs_hdf5.isolation import isolated

NAME = "scans"
HELP = "list, add, extract and delete the scans, poses and images in a map file"
EXAMPLE = "mesh_tool scans add garden.h5 scan0.pcd scan1.pcd --poses poses.txt"
_ACTIONS = {
    "list": ("the scans (meant if no action is given); no points are read", "garden.h5"),
    "add": ("add point clouds, or images of a scan", "garden.h5 scan0.pcd --poses poses.txt"),
    "extract": ("write clouds, images and poses.txt into a folder", "garden.h5 scans/"),
    "delete": ("delete scans with their images", "garden.h5 position_00003"),
}
ACTIONS = tuple(_ACTIONS)
OTHER_GROUPS = (
    "%d groups below /raw/scans are no scans, which are called position_00000 and so on: %s"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add = add_actions(parser, NAME, _ACTIONS, of_a_part=False)
    text = "PLY or PCD files, each a scan"
    add["add"].add_argument("clouds", metavar="CLOUD", nargs="*", help=text)
    text = "a pose for each cloud, a line each, as KITTI (12 numbers) or TUM (8) have them"
    add["add"].add_argument("--poses", metavar="FILE", help=text)
    text = "PNG or JPEG files taken with the only cloud, or with --scan"
    add["add"].add_argument("--image", metavar="FILE", dest="images", nargs="+", help=text)
    text = "of the images, in pixels"
    add["add"].add_argument("--intrinsics", metavar="FX,FY,CX,CY", type=_numbers, help=text)
    add["add"].add_argument("--scan", metavar="SCAN", help="the scan that the images belong to")
    add["extract"].add_argument("folder", metavar="FOLDER", help="made if it is not there")
    add["extract"].add_argument("scans", metavar="SCAN", nargs="*", help="default: all")
    add["extract"].add_argument("--format", choices=("pcd", "ply"), default="pcd")
    text = "of poses.txt (default: kitti), or none"
    poses = ("kitti", "tum", "none")
    add["extract"].add_argument("--poses", choices=poses, default="kitti", help=text)
    add["extract"].add_argument("--force", action="store_true", help="replace files that are there")
    add["delete"].add_argument("scans", metavar="SCAN", nargs="+")


def _numbers(text):
    fx, fy, cx, cy = text.split(",")
    return [float(word) for word in (fx, fy, cx, cy)]


_numbers.__name__ = "four numbers fx,fy,cx,cy"  # of the error


def run(arguments: argparse.Namespace) -> int:
    code, notes = 0, []
    with ProgressLine(arguments.quiet) as progress:
        progress.stage("reading " + arguments.file)
        if arguments.action == "list":
            entries = isolated("scans", arguments.file)
            value: Dict[str, Any] = {"path": arguments.file, "scans": entries}
            lines = [_line(entry) for entry in entries] or ["%s: no scans" % arguments.file]
            others = isolated("other_scan_groups", arguments.file)
            if others:
                notes = [OTHER_GROUPS % (len(others), ", ".join(map(one_line, others[:5])))]
            arguments.quiet = False  # what was asked for
        else:
            text, notes, code = _CHANGES[arguments.action](arguments)
            value = {"path": arguments.file, "action": arguments.action, "done": text}
            lines = ["%s: %s" % (arguments.file, text)]
    value["notes"] = notes
    say(arguments, value, lines + ["  note: " + note for note in notes])
    return code


def _line(entry) -> str:
    if entry["problem"]:
        return "%s: cannot be read: %s" % (entry["name"], entry["problem"])
    pose = entry["final_pose"] if entry["final_pose"] is not None else entry["initial_pose"]
    at = "no pose" if pose is None else "at %g %g %g m" % tuple(pose[:3, 3])
    others = [name for name in entry["channels"] if name != "points"]
    text = "%s: %d points%s, %s" % (
        entry["name"],
        entry["points"],
        " with " + ", ".join(others) if others else "",
        at,
    )
    if entry["time"] is not None:
        text += ", time %.9g s" % entry["time"]
    return text + (", %d images" % len(entry["images"]) if entry["images"] else "")


def _add(arguments):
    clouds = [os.path.abspath(cloud) for cloud in arguments.clouds]
    added: Dict[str, List[str]] = isolated(
        "add_scans",
        arguments.file,
        clouds,
        arguments.poses and os.path.abspath(arguments.poses),
        [os.path.abspath(image) for image in arguments.images or ()],
        arguments.intrinsics,
        arguments.scan,
        timeout=_timeout(arguments.file, *clouds),
    )
    names, images = added["names"], len(arguments.images or ())
    text = "added scan %s" % ", ".join(names) if clouds else "added to scan %s" % names[0]
    text += ": %d image%s" % (images, "s" * (images != 1)) if images else ""
    return text, added["notes"], 0


def _extract(arguments):
    done = isolated(
        "extract_scans",
        arguments.file,
        os.path.abspath(arguments.folder),
        arguments.scans,
        arguments.format,
        arguments.poses,
        arguments.force,
        timeout=_timeout(arguments.file),
    )
    for text in done["unreadable"]:
        print(
            "mesh_tool: error: %s: left out: %s" % (arguments.file, one_line(text)), file=sys.stderr
        )
    text = "wrote %d files into %s" % (len(done["files"]), arguments.folder)
    left_out = ["left out: " + line for line in done["unreadable"]]
    return text, done["notes"] + (left_out if arguments.json else []), int(bool(left_out))


def _delete(arguments):
    isolated("delete_scans", arguments.file, arguments.scans, timeout=_timeout(arguments.file))
    return "deleted scan %s" % ", ".join(dict.fromkeys(arguments.scans)), [], 0


def _timeout(*paths):
    """Seconds: what is large takes longer."""
    size = sum(os.path.getsize(path) for path in paths if os.path.isfile(path))
    return 600 + size / (1 << 20)


_CHANGES = {"add": _add, "extract": _extract, "delete": _delete}
