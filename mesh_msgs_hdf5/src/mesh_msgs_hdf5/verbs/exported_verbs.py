"""Verbs that packages export for mesh_tool, as layers and planners are exported.

package.xml:

    <export><mesh_msgs_hdf5 verbs="${prefix}/verbs.xml"/></export>

verbs.xml:

    <verbs>
      <verb name="layers compute" module="my_package.commands.layers_compute">
        <description>compute cost layers, and store them with the map</description>
      </verb>
    </verbs>

A name of two words is an action of a verb that has some. The module, which can be imported where
the package is sourced, has HELP, EXAMPLE, add_arguments(parser) and run(arguments), as those of
mesh_msgs_hdf5.commands.
"""
import re
from typing import Any, Callable, Dict, List, Tuple

from mesh_msgs.package_exports import exported_files, exporting_packages, read_description
from mesh_msgs.text import one_line
from mesh_msgs_hdf5.verbs.exported_verb import ExportedVerb

TAG, ATTRIBUTE = "mesh_msgs_hdf5", "verbs"
_NAME = re.compile(r"[a-z][a-z0-9-]*( [a-z][a-z0-9-]*)?")
_MODULE = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)+", re.ASCII)


def exported_verbs(fault: Callable[[str], str]) -> Tuple[Dict[str, ExportedVerb], List[str]]:
    """The verbs of all packages by their names, and a line for each export that cannot be used.

    fault: why a name cannot be one; "" if it can. Of two of one name, the one of the package that
    comes first in alphabetical order counts.
    """
    verbs: Dict[str, ExportedVerb] = {}
    folders, unreadable = exporting_packages(TAG)
    problems = [_left_out(folder, error) for folder, error in unreadable]
    for package in sorted(folders):
        try:
            paths = exported_files(folders[package], TAG, ATTRIBUTE)
            elements = [element for path in paths for element in read_description(path)]
        except Exception as error:  # a stranger's package.xml may bring out anything
            problems.append(_left_out(folders[package], error))
            continue
        for element in elements:
            verb = _verb(element, package)
            wrong = _fault(verb) or fault(verb.name)
            if not wrong and verb.name in verbs:
                wrong = "package %s has one of this name" % verbs[verb.name].package
            if wrong:
                text = "verb %r of package %s is left out: %s"
                problems.append(one_line(text % (verb.name[:80], package, wrong)))
            else:
                verbs[verb.name] = verb
    return verbs, problems


def _verb(element: Any, package: str) -> ExportedVerb:
    name = " ".join(element.get("name", "").split())
    text = " ".join(element.findtext("description", "").split())
    return ExportedVerb(name, element.get("module", ""), package, one_line(text))


def _fault(verb: ExportedVerb) -> str:
    if not _NAME.fullmatch(verb.name):
        return "a name is one word, or two, of a-z, 0-9 and -"
    if not _MODULE.fullmatch(verb.module):
        return "its module %r is none of the form package.module" % verb.module[:80]
    return ""


def _left_out(folder: str, error: Exception) -> str:
    return "verbs of package %s are left out: %s" % (folder, one_line(str(error)))
