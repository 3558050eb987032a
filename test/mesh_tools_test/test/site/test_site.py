"""The site is built without a warning, and shows what it says."""
import os
import re

import pytest

from mesh_tools_test.site import assembly
from mesh_tools_test.site.main import has_run

pytestmark = pytest.mark.timeout(1200)  # it takes a core for a minute, which others may want, too


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site without pictures of tutorials, which their own tests make: source and HTML."""
    folder = tmp_path_factory.mktemp("site")
    missing = assembly.assemble(folder / "source", folder / "none")
    assert missing == assembly.shown_pictures()
    assembly.build(folder / "source", folder / "html")
    return folder


def pages(site):
    return sorted((site / "html").rglob("*.html"))


def test_each_page_of_docs_is_in_the_site(site):
    found = {path.relative_to(site / "html").with_suffix("") for path in pages(site)}
    wanted = {
        path.relative_to(assembly.DOCS).with_suffix("") for path in assembly.DOCS.rglob("*.md")
    }
    assert wanted <= found


def test_links_and_pictures_of_all_pages_are_there(site):
    anchors = {
        path: set(re.findall(r'\bid="([^"]+)"', path.read_text(encoding="utf-8")))
        for path in pages(site)
    }
    lost = []
    for path in anchors:
        text = path.read_text(encoding="utf-8")
        for target in re.findall(r'<(?:a|img)\b[^>]*?\b(?:href|src)="([^"]+)"', text):
            if re.match(r"\w+:", target):
                continue
            name, _, anchor = target.partition("#")
            goal = (path.parent / name).resolve() if name else path
            if not goal.exists() or (anchor and anchor not in anchors.get(goal, {anchor})):
                lost.append((str(path.relative_to(site / "html")), target))
    assert not lost


def test_nothing_of_the_machine_is_in_the_site(site):
    for path in pages(site):
        assert str(assembly.ROOT) not in path.read_text(encoding="utf-8"), path


def test_a_warning_of_sphinx_is_an_error(tmp_path):
    source = tmp_path / "source"
    source.mkdir()
    (source / "conf.py").write_text("extensions = ['myst_parser']\n", encoding="utf-8")
    (source / "index.rst").write_text("A page\n======\n\n:doc:`none`\n", encoding="utf-8")
    with pytest.raises(assembly.SiteError, match="unknown document"):
        assembly.build(source, tmp_path / "html")


def test_pictures_that_are_there_are_taken(tmp_path):
    name = sorted(assembly.shown_pictures())[0]
    (tmp_path / name).write_bytes(b"a picture")
    placed = tmp_path / "placed"
    assert assembly.place_pictures(placed, tmp_path) == assembly.shown_pictures() - {name}
    assert (placed / name).read_bytes() == b"a picture"
    assert {path.name for path in placed.iterdir()} == assembly.shown_pictures()


def test_a_tutorial_is_done_again_where_its_page_is_newer(tmp_path):
    tutorial = next(iter(assembly.tutorials().values()))
    assert not has_run(tutorial, tmp_path)
    done = tmp_path / (tutorial.path.name + ".done")
    done.touch()
    assert has_run(tutorial, tmp_path)
    os.utime(str(done), (0, 0))
    assert not has_run(tutorial, tmp_path)
