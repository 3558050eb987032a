"""The page of the C++ library, from what doxygen reads of its headers; shown by breathe.

In conf.py, with "breathe" among the extensions: breathe_projects = {PROJECT: "reference/" + XML}
"""
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Dict, Iterator, List, Tuple

from mesh_tools_test.reference.markdown import block, page
from mesh_tools_test.reference.repository import ROOT

PROJECT, XML = "mesh_map", "doxygen/xml"  # below the folder of the reference
_OF_PROJECT = "   :project: %s\n" % PROJECT
_HEADERS = ROOT / "mesh_map/include"
_SETTINGS = {
    "PROJECT_NAME": PROJECT,
    "INPUT": str(_HEADERS),
    "STRIP_FROM_PATH": str(_HEADERS),
    "RECURSIVE": "YES",
    "EXTRACT_ALL": "YES",
    "JAVADOC_AUTOBRIEF": "YES",
    "GENERATE_HTML": "NO",
    "GENERATE_LATEX": "NO",
    "GENERATE_XML": "YES",
    "XML_PROGRAMLISTING": "NO",
    "QUIET": "YES",
}


def write_xml(folder: Path) -> None:
    """Have doxygen write what it reads of the headers; raises RuntimeError with its warnings."""
    folder.mkdir(parents=True, exist_ok=True)
    settings = dict(_SETTINGS, OUTPUT_DIRECTORY=str(folder), XML_OUTPUT=XML)
    (folder / XML).parent.mkdir(exist_ok=True)
    done = subprocess.run(
        ["doxygen", "-"],
        input="".join('%s = "%s"\n' % setting for setting in settings.items()).encode(),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    if done.returncode or done.stdout.strip():
        raise RuntimeError("doxygen: " + done.stdout.decode("utf-8", "replace").strip()[:2000])


def _classes(header: ElementTree.Element) -> Iterator[str]:
    """Breathe's directive for each class of what doxygen says of a header."""
    for inner in header.iterfind("compounddef/innerclass"):
        if inner.text and inner.text.count("::") == 1:  # others are members
            kind = "class" if inner.attrib["refid"].startswith("class") else "struct"
            yield ".. doxygen%s:: %s\n   :members:\n" % (kind, inner.text)


def _others(namespace: ElementTree.Element) -> Iterator[Tuple[str, str]]:
    """Header and directive of each function, enumeration, ... of a namespace."""
    members = list(namespace.iterfind("compounddef/sectiondef/memberdef"))
    names = [member.findtext("qualifiedname", "") for member in members]
    for name, member in zip(names, members):
        place = member.find("location").attrib
        kind = member.attrib["kind"]
        if kind == "function" and names.count(name) > 1:
            types = ["".join(one.find("type").itertext()) for one in member.iterfind("param")]
            name = "%s(%s)" % (name, ", ".join(types))
        yield place.get("declfile", place["file"]), ".. doxygen%s:: %s\n" % (kind, name)


def cpp_page(folder: Path) -> str:
    """The page, header by header.

    :param folder: where write_xml() has written
    """
    entities: Dict[str, List[str]] = {}
    for path in sorted((folder / XML).glob("*_8h.xml")):
        header = ElementTree.parse(str(path)).getroot()
        name = header.find("compounddef/location").attrib["file"]
        entities.setdefault(name, []).extend(_classes(header))
    for path in sorted((folder / XML).glob("namespacemesh*.xml")):
        for name, directive in _others(ElementTree.parse(str(path)).getroot()):
            entities[name].append(directive)
    sections = [
        page("## " + name, block("\n".join(one + _OF_PROJECT for one in found), "{eval-rst}"))
        for name, found in sorted(entities.items())
        if found
    ]
    return page(
        "# C++: mesh_map",
        "The headers of the library `mesh_map_core`, which needs neither ROS nor Python. What"
        " stands in `mesh_map/src` beside them is its own.",
        *sections,
    )
