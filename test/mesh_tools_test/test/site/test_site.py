"""The site is built without a warning, shows what it says, and needs no network for it."""
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


def test_pages_that_help_names_are_there(site):
    commands = (site / "html/reference/commands.html").read_text(encoding="utf-8")
    named = set(re.findall(r"build/docs/html/reference/(\S+?\.html)#([\w-]+), ", commands))
    assert len(named) >= 10
    for name, anchor in named:
        text = (site / "html/reference" / name).read_text(encoding="utf-8")
        assert 'id="%s"' % anchor in text, (name, anchor)


# What a browser fetches to show a page: by tags, style sheets, scripts and pictures.
_QUOTE, _HOST = r"""["'`]""", r"(?:https?:)?//"
FETCHED = {
    "html": re.compile(
        r"<(?:script|link|img|iframe|object|embed|source|video|audio)\b[^>]*"
        r"\b(?:src|srcset|href|data)\s*=\s*" + _QUOTE + _HOST
    ),
    "css": re.compile(r"(?:\burl\(|@import)\s*" + _QUOTE + "?" + _HOST),
    "js": re.compile(r"\b(?:import|from|fetch|importScripts|src)\b[\s=(]*" + _QUOTE + _HOST),
    "svg": re.compile(r"\b(?:href|src)\s*=\s*" + _QUOTE + _HOST),
}
LOADS = [
    ("html", '<script type="module">import mermaid from "https://unpkg.com/mermaid";</script>'),
    ("html", '<script async="async" src="https://cdn.jsdelivr.net/npm/mathjax@3"></script>'),
    ("html", '<link rel="stylesheet" href="//fonts.googleapis.com/css" />'),
    ("html", "<style>@import url(https://fonts.googleapis.com/css);</style>"),
    ("css", "@font-face { src: url('https://fonts.gstatic.com/a.woff') }"),
    ("js", 'script.src = "https://cdn.org/a.js";'),
    ("svg", '<image xlink:href="http://host/a.png"/>'),
]
LOADS_NOTHING = [
    ("html", '<a class="reference external" href="https://github.com">code</a>'),
    ("html", '<script src="_static/doctools.js"></script>'),
    ("svg", '<svg xmlns:xlink="http://www.w3.org/1999/xlink">'),
    ("js", "// copied from https://host/a.js"),
]


def fetched_elsewhere(kind, text):
    """What a file of that kind loads from another host."""
    found = FETCHED[kind].findall(text)
    if kind == "html":  # scripts and style sheets within the page
        for of, tag in (("js", "script"), ("css", "style")):
            for inner in re.findall(r"<%s\b[^>]*>(.*?)</%s>" % (tag, tag), text, re.DOTALL):
                found += FETCHED[of].findall(inner)
    return found


@pytest.mark.parametrize("kind, text", LOADS)
def test_what_is_loaded_from_elsewhere_is_seen(kind, text):
    assert fetched_elsewhere(kind, text)


@pytest.mark.parametrize("kind, text", LOADS_NOTHING)
def test_what_only_names_another_host_loads_nothing(kind, text):
    assert not fetched_elsewhere(kind, text)


def test_no_page_loads_anything_from_another_host(site):
    found = {
        str(path.relative_to(site / "html")): fetched_elsewhere(kind, path.read_text("utf-8"))
        for kind in FETCHED
        for path in (site / "html").rglob("*." + kind)
    }
    assert len(found) > 50
    assert not {name: loads for name, loads in found.items() if loads}


def test_diagrams_and_formulas_are_in_the_pages_themselves(site):
    architecture = (site / "html" / "architecture.html").read_text(encoding="utf-8")
    (diagram,) = re.findall(r'<object data="([^"]+\.svg)"', architecture)
    svg = (site / "html" / diagram).read_text(encoding="utf-8")
    assert ">mesh_navigation<" in svg and svg.count('class="edge"') >= 10
    planning = (site / "html" / "concepts" / "planning.html").read_text(encoding="utf-8")
    assert planning.count("<math xmlns") >= 5 and "\\nabla" not in planning


def test_a_formula_that_cannot_be_drawn_is_an_error(tmp_path):
    source = tmp_path / "source"
    source.mkdir()
    conf = "extensions = ['mesh_tools_test.site.mathml']\nhtml_math_renderer = 'mathml'\n"
    (source / "conf.py").write_text(conf, encoding="utf-8")
    (source / "index.rst").write_text("A page\n======\n\n:math:`\\noword x`\n", encoding="utf-8")
    with pytest.raises(assembly.SiteError, match="noword"):
        assembly.build(source, tmp_path / "html")


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
