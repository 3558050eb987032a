"""READMEs of packages as pages: their links lead to other pages, or are plain text."""
import os
import re
import shutil
from pathlib import Path
from typing import Dict

from mesh_tools_test.reference.markdown import code
from mesh_tools_test.reference.repository import ROOT

_LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
_ELSEWHERE = re.compile(r"^(?:\w+:|#)")
README = "README.md"


class PackagePages:
    """Pages `packages/<name>.md`.

    :param packages: name -> folder
    :param folder: of the pages of the reference, below which `packages/` is made
    :param top: of the whole site, where the pages of docs/ are
    """

    def __init__(self, packages: Dict[str, Path], folder: Path, top: Path):
        self._pages = {
            path: folder / "packages" / (name + ".md") for name, path in packages.items()
        }
        self._top = top

    def write_page(self, source: Path, page: Path) -> None:
        """Write a page that is kept by hand, such as one below docs/, with good links."""
        text = source.read_text(encoding="utf-8")
        page.write_text(self.relinked(text, source.parent, page), encoding="utf-8")

    def write(self) -> None:
        """Write the page of each package, with its pictures."""
        for source, page in self._pages.items():
            page.parent.mkdir(parents=True, exist_ok=True)
            self.write_page(source / README, page)

    def relinked(self, text: str, source: Path, page: Path) -> str:
        """A README with links that are good on its page.

        :param source: the folder that it is in
        """
        return _LINK.sub(lambda found: self._link(found, source, page), text)

    def _link(self, found: "re.Match[str]", source: Path, page: Path) -> str:
        picture, text, target = found.groups()
        if _ELSEWHERE.match(target):
            return found.group()
        name, mark, anchor = target.partition("#")
        path = Path(os.path.normpath(source / name))
        if not path.exists():
            raise ValueError("%s: a link to %s, which is not there" % (source / README, target))
        if picture:
            copy = page.parent / page.stem / path.name
            copy.parent.mkdir(exist_ok=True)
            shutil.copyfile(str(path), str(copy))
            return "![%s](%s)" % (text, copy.relative_to(page.parent).as_posix())
        goal = self._page_of(path)
        if goal is None:
            return _named(text, path.relative_to(ROOT).as_posix())
        return "[%s](%s%s%s)" % (text, os.path.relpath(goal, page.parent), mark, anchor)

    def _page_of(self, path: Path):
        """The page that a file or folder has become, None where it has become none."""
        folder = path.parent if path.name == README else path
        if folder in self._pages:
            return self._pages[folder]
        docs = ROOT / "docs"
        if docs in path.parents and path.suffix == ".md":
            return self._top / path.relative_to(docs)
        return None


def _named(text: str, path: str) -> str:
    """Instead of a link to a source."""
    if path.endswith(text.strip("`")):
        return code(path)
    return "%s (%s)" % (text, code(path))
