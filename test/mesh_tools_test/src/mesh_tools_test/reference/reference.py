"""The reference: pages that are made of the code, and of what the READMEs say of it.

    python3 -m mesh_tools_test.reference.reference FOLDER
"""
import sys
from pathlib import Path

from mesh_msgs_hdf5.validation.findings import RULES

from mesh_tools_test.reference.command_pages import command_page
from mesh_tools_test.reference.cpp_pages import cpp_page, write_xml
from mesh_tools_test.reference.markdown import code, plain, table
from mesh_tools_test.reference.message_pages import message_page
from mesh_tools_test.reference.node_pages import node_page
from mesh_tools_test.reference.package_pages import PackagePages
from mesh_tools_test.reference.plugin_pages import plugin_page
from mesh_tools_test.reference.python_pages import PACKAGES, python_page
from mesh_tools_test.reference.repository import ROOT, packages


def write_reference(folder: Path) -> None:
    """Write all pages into a folder, which is that of docs/reference in the site.

    :raises ValueError, RuntimeError: code that cannot be documented; the text says what
    """
    known = packages()
    folder.mkdir(parents=True, exist_ok=True)
    pages = PackagePages(known, folder, folder.parent)
    pages.write()
    for path in sorted((ROOT / "docs/reference").glob("*.md")):
        pages.write_page(path, folder / path.name)
    rules = [(code(rule), plain(meaning)) for rule, meaning in RULES.items()]
    _write(folder / "rules.inc", table(("rule", ""), rules))  # part of file_format.md
    _write(folder / "nodes.md", node_page(known, pages, folder / "nodes.md"))
    _write(folder / "plugins.md", plugin_page(known))
    _write(folder / "commands.md", command_page(known))
    write_xml(folder)
    _write(folder / "cpp.md", cpp_page(folder))
    for name in PACKAGES:
        _write(folder / "python" / (name + ".md"), python_page(name, known))
    for name, path in known.items():
        _write(folder / "messages" / (name + ".md"), message_page(name, path))


def _write(path: Path, text: str) -> None:
    if text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    write_reference(Path(sys.argv[1]))
