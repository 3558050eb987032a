"""The parameters of hdf5_map_server."""
import math
import os
from dataclasses import dataclass, field
from typing import Any, Dict, List, Optional, Sequence

DEFAULT_FILE = "/tmp/map.h5"
ALL_PARTS, ROOT = "", "/"
_MAX_DELAY = 3600.0


@dataclass(frozen=True)
class MapRequest:
    """A map to be served.

    path: absolute. part: a part of a map file; "/" is the root, ALL_PARTS all of them, None "mesh"
    or the only one. given: the path as it was given, for check_node_path().
    """

    path: str
    part: Optional[str] = None
    given: str = field(default="", compare=False)


@dataclass(frozen=True)
class ServerOptions:
    """maps: without duplicates. read_only: nothing is stored. save_delay: seconds of quiet before
    what was received is saved. origin_frame: the parent of the frames of maps; "" for none.
    """

    maps: List[MapRequest] = field(default_factory=list)
    read_only: bool = False
    save_delay: float = 2.0
    origin_frame: str = ""


def parse(parameters: Dict[str, Any], arguments: Sequence[str] = ()) -> ServerOptions:
    """The options from the private parameters (name without ~ -> value).

    arguments: files, instead of those of ~inputFile. Raises ValueError: a sentence that names the
    parameter.
    """
    parts = _parts(parameters.get("mesh_part"))
    maps = _explicit(parameters.get("maps", []))
    for name in arguments:
        if name.startswith("-"):
            raise ValueError(
                "there is no option %s; give map files, and parameters as _n:=v" % name
            )
        maps += [MapRequest(_path("inputFile", name), part, str(name)) for part in parts]
    if not arguments and ("inputFile" in parameters or not maps):
        files = parameters.get("inputFile", DEFAULT_FILE)
        for name in files if isinstance(files, list) and files else [files]:
            maps += [MapRequest(_path("inputFile", name), part, str(name)) for part in parts]
    read_only = parameters.get("read_only", False)
    if not isinstance(read_only, bool):
        raise ValueError("~read_only is %r; give true or false" % (read_only,))
    delay = parameters.get("save_delay", 2.0)
    number = isinstance(delay, (int, float)) and not isinstance(delay, bool)
    if not number or not math.isfinite(delay) or not 0 <= delay <= _MAX_DELAY:
        raise ValueError("~save_delay is %r; give seconds from 0 to %d" % (delay, _MAX_DELAY))
    frame = parameters.get("origin_frame", "")
    if not isinstance(frame, str) or frame.startswith("/") or not frame.isprintable():
        raise ValueError("~origin_frame is %r; give the name of a frame, without /" % (frame,))
    return ServerOptions(list(dict.fromkeys(maps)), read_only, float(delay), frame)


def _explicit(entries):
    if not isinstance(entries, list):
        raise ValueError("~maps is %r; give a list of {file: ..., part: ...}" % (entries,))
    found = []
    for number, entry in enumerate(entries):
        if not isinstance(entry, dict) or not set(entry) <= {"file", "part"} or "file" not in entry:
            raise ValueError(
                "~maps[%d] is %r; give {file: ..., part: ...} (part may be left out)"
                % (number, entry)
            )
        path = _path("maps[%d].file" % number, entry["file"])
        given = str(entry["file"])
        found += [MapRequest(path, part, given) for part in _parts(entry.get("part"))]
    return found


def _path(name, value):
    # a name of digits comes as a number from the command line
    text = str(value) if isinstance(value, (str, int, float)) else ""
    if not text or "\0" in text or isinstance(value, bool):
        raise ValueError("~%s is %r; give the path of a map file or a mesh" % (name, value))
    # absolute: a relative one counts from where the node runs, with roslaunch ~/.ros
    return os.path.abspath(text)


def _parts(value):
    values = (value or [None]) if isinstance(value, list) else [value]
    for part in values:
        if part is not None and (isinstance(part, bool) or not isinstance(part, (str, int, float))):
            raise ValueError("~mesh_part is %r; give the name of a part, or a list" % (value,))
    return [None if part is None else str(part) for part in values]
