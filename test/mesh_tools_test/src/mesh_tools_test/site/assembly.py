"""The folder that Sphinx reads: docs/ with the pages that are made of the code, and pictures."""
import os
import shutil
import subprocess
import sys
import xml.etree.ElementTree as xml
from pathlib import Path
from typing import Dict, Set

from PIL import Image

from mesh_tools_test.reference.package_pages import PackagePages
from mesh_tools_test.reference.reference import write_reference
from mesh_tools_test.reference.repository import ROOT, packages
from mesh_tools_test.site.diagrams import drawn
from mesh_tools_test.tutorials.tutorial import Tutorial, read_tutorial

DOCS = ROOT / "docs"


class SiteError(Exception):
    """The site cannot be built; the text says why."""


def tutorials() -> Dict[str, Tutorial]:
    """Those of the site, by the names of their files; a page of concepts makes pictures, too."""
    pages = sorted(path for path in (DOCS / "tutorials").glob("*.md") if path.name != "index.md")
    pages.append(DOCS / "concepts" / "performance.md")
    return {page.name: read_tutorial(page) for page in pages}


def shown_pictures() -> Set[str]:
    """Names of all pictures that tutorials make."""
    return {name for tutorial in tutorials().values() for name in tutorial.pictures}


def assemble(source: Path, pictures: Path) -> Set[str]:
    """Make the folder anew.

    :param pictures: what the runs of tutorials have left
    :returns: the names of pictures that are not there, in whose place there is a grey one
    """
    shutil.rmtree(str(source), ignore_errors=True)
    shutil.copytree(str(DOCS), str(source))
    links = PackagePages(packages(), source / "reference", source)
    for path in [DOCS / "architecture.md", *(DOCS / "troubleshooting").glob("*.md")]:
        page = source / path.relative_to(DOCS)
        links.write_page(path, page)
        page.write_text(drawn(page.read_text(encoding="utf-8")), encoding="utf-8")
    write_reference(source / "reference")
    return place_pictures(source / "tutorials" / "pictures", pictures)


def place_pictures(folder: Path, pictures: Path) -> Set[str]:
    """Copy those that there are; grey ones, whose names are returned, in place of the others."""
    folder.mkdir(parents=True)
    missing = set()
    for name in shown_pictures():
        if (pictures / name).is_file():
            shutil.copyfile(str(pictures / name), str(folder / name))
        else:
            missing.add(name)
            Image.new("RGB", (320, 240), (128, 128, 128)).save(folder / name)
    return missing


def version() -> str:
    """That of the packages."""
    return xml.parse(str(ROOT / "mesh_msgs" / "package.xml")).findtext("version", "")


def build(source: Path, html: Path) -> None:
    """Let Sphinx make HTML; a warning is an error.

    :raises SiteError: with what Sphinx says
    """
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html"]
    ended = subprocess.run(
        [*command, "-d", str(html.parent / "doctrees"), str(source), str(html)],
        env=dict(os.environ, MESH_TOOLS_VERSION=version()),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    if ended.returncode != 0:
        raise SiteError(ended.stdout.decode("utf-8", "replace"))
