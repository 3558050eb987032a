"""Pages of the Python modules that READMEs name for programmers, made by Sphinx's autodoc."""
import importlib
import importlib.util
import re
from pathlib import Path
from typing import Dict, Iterator, List

from mesh_tools_test.reference.markdown import block, page
from mesh_tools_test.reference.readme_tables import Table, tables_of

PACKAGES = ("mesh_msgs", "mesh_msgs_hdf5", "mesh_map", "mesh_navigation", "mesh_localization")
_NAME = re.compile(r"(?<![\w./:])(?:%s)(?:\.\w+)+" % "|".join(PACKAGES))
_IMPORT = re.compile(r"^\s*from ([\w.]+) import ([\w, ]+)$", re.MULTILINE)
_OPTIONS = "   :members:\n   :show-inheritance:\n   :member-order: bysource\n"


def module_of(name: str) -> str:
    """The module that a dotted name is, or is in; "" for none below a package."""
    parts = name.split(".")
    while len(parts) > 1:
        try:
            if importlib.util.find_spec(".".join(parts)):
                return ".".join(parts)
        except ImportError:  # what is above is no package
            pass
        parts.pop()
    return ""


def _in_table(package: str, table: Table) -> Iterator[str]:
    """The names in a table of modules: in full, below the bold one above, or below the package."""
    above = package
    for row in table.rows:
        for code in row[0].codes:
            if row[0].text.startswith("**"):
                above = code
                yield code
            elif code.startswith("."):
                yield above + code
            elif code.split(".")[0] not in PACKAGES:
                yield "%s.%s" % (package, code)


def _imported(text: str) -> Iterator[str]:
    """The modules where the things are defined that programs in a README import."""
    for module, names in _IMPORT.findall(text):
        if module.split(".")[0] in PACKAGES:
            for name in names.split(", "):
                found = getattr(importlib.import_module(module), name.strip(), None)
                yield getattr(found, "__module__", "")


def documented_modules(package: str, readme: Path) -> List[str]:
    """Those of a package that its README names."""
    text = readme.read_text(encoding="utf-8")
    names = {*_NAME.findall(text), *_imported(text)}
    for table in tables_of(readme):
        if table.header[0] in ("module", "name") and "Python" in table.headings:
            names |= set(_in_table(package, table))
    found = {module_of(name) for name in names if name.startswith(package + ".")}
    return sorted(found - {""})


def _module(name: str) -> str:
    directive = ".. automodule:: %s\n%s" % (name, _OPTIONS)
    return page("## " + name, block(directive, "{eval-rst}"))


def python_page(package: str, packages: Dict[str, Path]) -> str:
    """The page of a package."""
    modules = documented_modules(package, packages[package] / "README.md")
    return page(
        "# Python: " + package,
        "Modules for programmers; an overview stands [with the package](../packages/%s.md)."
        % package,
        *(_module(name) for name in modules),
    )
