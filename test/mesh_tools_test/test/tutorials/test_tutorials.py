"""Each tutorial is done as it stands on its page, and what makes pictures for another page."""
import os
from pathlib import Path

import pytest

from mesh_tools_test.tutorials.tutorial import read_tutorial
from mesh_tools_test.tutorials.tutorial_run import run_tutorial

DOCS = Path(__file__).resolve().parents[4] / "docs"
FOLDER = DOCS / "tutorials"
PAGES = sorted(path for path in FOLDER.glob("*.md") if path.name != "index.md")


def test_all_pages_are_in_the_table_of_contents():
    index = (FOLDER / "index.md").read_text(encoding="utf-8")
    assert [line for line in index.splitlines() if line in {page.stem for page in PAGES}] == [
        page.stem for page in PAGES
    ]
    assert len(PAGES) == 12


@pytest.mark.parametrize(
    "page", [*PAGES, DOCS / "concepts" / "performance.md"], ids=lambda page: page.stem
)
def test_tutorial(page, tmp_path):
    results = os.environ.get("CATKIN_TEST_RESULTS_DIR")
    pictures = Path(results) / "mesh_tools_test" / "tutorials" if results else tmp_path / "pictures"
    run_tutorial(read_tutorial(page), pictures)
