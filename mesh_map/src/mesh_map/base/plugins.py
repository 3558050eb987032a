"""Plugins in Python, described in XML and exported from package.xml as pluginlib and rqt do.

package.xml of a package with layers (the tag is the name of the package that uses the plugins):

    <export><mesh_map plugin="${prefix}/layers.xml"/></export>

layers.xml:

    <library path="my_package">
      <class name="my_layers/SlopeLayer" type="my_package.slope.SlopeLayer"
             base_class_type="mesh_map::Layer">
        <description>What it does.</description>
      </class>
    </library>

`type` is a class in a module that can be imported where the package is sourced, in devel and
install space alike. The root may also be <class_libraries> with several libraries in it.
"""

import contextlib
import contextvars
import functools
import importlib
import logging
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Optional, Set, Tuple

from mesh_msgs.package_exports import exported_files, exporting_packages, read_description
from mesh_msgs.text import one_line

from mesh_map.base.errors import PLUGIN_FAILURES, PluginError, UnknownPluginError

Scan = Callable[[str, str], Any]

_LOG = logging.getLogger("mesh_map")
_TOLD: Set[str] = set()  # what was logged
# Within scanned_once() the _scan() that remembers.
_SCANS: "contextvars.ContextVar[Optional[Scan]]" = contextvars.ContextVar("scans", default=None)


class Plugin(NamedTuple):
    """What is said about a plugin.

    name: as users write it.
    type: module and class.
    package: where it is described.
    """

    name: str
    type: str
    package: str


def find_class(package: str, base_class_type: str, type_name: str) -> type:
    """The class of a plugin that a package on ROS_PACKAGE_PATH exports for `package`.

    A package or description that cannot be read is left out and logged, once; of two plugins of
    one name, the first package counts (its own before others, then in alphabetical order).

    Args:
        package: the package that uses the plugins, such as "mesh_map"; its name is the export tag.
        base_class_type: such as "mesh_map::Layer".
        type_name: the name of the plugin, such as "mesh_layers/HeightDiffLayer".
    Raises:
        PluginError: no such plugin (the known ones are named, and what was left out), or it cannot
            be imported.
    """
    plugins, problems = (_SCANS.get() or _scan)(package, base_class_type)
    plugin = plugins.get(type_name)
    if plugin is None:
        known = "known: " + (", ".join(sorted(plugins)) or "none")
        raise UnknownPluginError(
            "there is no %s of the type %s" % (base_class_type, type_name),
            "; ".join([known] + problems),
        )
    module_name, _, class_name = plugin.type.rpartition(".")
    try:
        found = getattr(importlib.import_module(module_name), class_name)
    except PLUGIN_FAILURES as error:  # while it is imported
        raise PluginError(
            "%s: %s of package %s cannot be imported: %s: %s"
            % (type_name, plugin.type, plugin.package, type(error).__name__, one_line(error)),
            "is the workspace with this package sourced?",
        ) from error
    if not isinstance(found, type):
        raise PluginError("%s: %s is no class" % (type_name, plugin.type))
    return found


def plugin_names(package: str, base_class_type: str) -> List[str]:
    """The names of all plugins that find_class() finds, in alphabetical order."""
    return sorted((_SCANS.get() or _scan)(package, base_class_type)[0])


@contextlib.contextmanager
def scanned_once() -> Iterator[None]:
    """Within, packages are looked through once, however many plugins this context asks for.

    Each look takes 60 ms where a few hundred packages are installed.
    """
    if _SCANS.get():  # within another one
        yield
        return
    token = _SCANS.set(functools.lru_cache(maxsize=None)(_scan))
    try:
        yield
    finally:
        _SCANS.reset(token)


def _scan(package: str, base_class_type: str) -> Tuple[Dict[str, Plugin], List[str]]:
    """The plugins, and one line for each description that cannot be used, which is logged once."""
    plugins: Dict[str, Plugin] = {}
    folders, unreadable = exporting_packages(package)
    problems = [_left_out(*one) for one in unreadable]
    for name in sorted(folders, key=lambda name: (name != package, name)):
        try:
            paths = exported_files(folders[name], package, "plugin")
            found = [plugin for path in paths for plugin in _read(path, name, base_class_type)]
        except Exception as error:  # a stranger's package.xml may bring out anything
            problems.append(_left_out(folders[name], error))
            continue
        for plugin in found:
            first = plugins.setdefault(plugin.name, plugin)
            if first is not plugin:
                problems.append(
                    "plugin %s of package %s is left out: package %s has one of this name"
                    % (plugin.name, name, first.package)
                )
    for problem in problems:
        if problem not in _TOLD:
            _TOLD.add(problem)
            _LOG.warning("%s", problem)
    return plugins, problems


def _left_out(folder: str, error: Exception) -> str:
    return "plugins of package %s are left out: %s" % (folder, one_line(error))


def _read(path: str, package: str, base_class_type: str) -> List[Plugin]:
    plugins = []
    for element in read_description(path).iter("class"):
        if element.get("base_class_type") != base_class_type:
            continue
        type_path = element.get("type", "")
        name = element.get("name") or type_path
        if "." not in type_path:
            raise PluginError("%s: %s needs a type of the form module.Class" % (path, name))
        plugins.append(Plugin(name, type_path, package))
    return plugins
