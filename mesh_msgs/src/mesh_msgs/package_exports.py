"""What packages export in package.xml for another one: plugins, verbs of commands.

    <export><mesh_map plugin="${prefix}/layers.xml"/></export>

The tag is the name of the package that uses it, the attribute says what it is, and the value is an
XML file that describes it. Packages are found where rospkg finds them.
"""

import os
from typing import Dict, Iterator, List, NamedTuple, Tuple
from xml.etree import ElementTree

import rospkg
from rospkg.manifest import parse_manifest_file

_MAX_BYTES = 1 << 20  # of an XML file; anything larger is no description


class LeftOut(NamedTuple):
    """A package whose exports cannot be used.

    folder: of the package.
    error: why.
    """

    folder: str
    error: Exception


def exporting_packages(tag: str) -> Tuple[Dict[str, str], List[LeftOut]]:
    """Name -> folder of the packages that export something under this tag, and those that would,
    but cannot be read; of packages of one name the first on ROS_PACKAGE_PATH counts.
    """
    folders: Dict[str, str] = {}
    hidden = set()
    problems = []
    for folder in _folders():
        text = b""
        try:
            with open(os.path.join(folder, rospkg.common.PACKAGE_FILE), "rb") as file:
                text = file.read(_MAX_BYTES)
            root = ElementTree.fromstring(text)
            name = root.findtext("name", "").strip()
            if not name:
                raise ValueError("it has no name")
        except Exception as error:  # a stranger's package.xml may bring out anything
            if b"<" + tag.encode() in text:
                problems.append(LeftOut(folder, error))
            continue
        if name not in hidden and root.find("export/" + tag) is not None:
            folders[name] = folder
        hidden.add(name)
    return folders, problems


def exported_files(folder: str, tag: str, attribute: str) -> List[str]:
    """The files that the package in a folder names; it may raise anything."""
    return list(parse_manifest_file(folder, rospkg.MANIFEST_FILE).get_export(tag, attribute))


def read_description(path: str) -> ElementTree.Element:
    """The root of an XML file of a stranger.

    Raises:
        OSError: it cannot be read.
        ValueError: it is no XML, or one that might grow or read other files.
    """
    with open(path, "rb") as file:
        text = file.read(_MAX_BYTES + 1)
    if len(text) > _MAX_BYTES:
        raise ValueError("%s is larger than 1 MB" % path)
    if b"<!" in text.replace(b"<!--", b""):
        # Entities can refer to other files and grow without bounds; a description needs none.
        raise ValueError("%s has a document type or CDATA, which is not allowed" % path)
    try:
        return ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise ValueError("%s is no XML: %s" % (path, error)) from error


def _folders() -> Iterator[str]:
    """Folders with a package.xml, found where rospkg finds them; its own list fails altogether at
    the first one that is no XML.
    """
    for path in rospkg.get_ros_paths():
        for folder, inner, files in os.walk(os.path.abspath(path), followlinks=True):
            is_ignored = "CATKIN_IGNORE" in files
            is_package = rospkg.common.PACKAGE_FILE in files and not is_ignored
            if is_package:
                yield folder
            ends = {rospkg.MANIFEST_FILE, "rospack_nosubdirs"}.intersection(files)
            if is_ignored or is_package or ends or folder.startswith("/usr/share/"):
                inner.clear()
            inner[:] = [name for name in inner if not name.startswith(".")]
