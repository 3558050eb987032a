"""Sphinx's settings of the site: `./run docs` calls it on a copy of this folder."""
import os

from mesh_tools_test.reference import docstrings
from mesh_tools_test.site import mathml

project = "Mesh Tools"
author = "Mesh Tools developers"
copyright = author
version = release = os.environ.get("MESH_TOOLS_VERSION", "")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.graphviz",
    "mesh_tools_test.site.mathml",
    "sphinx_copybutton",
    "breathe",
]
myst_enable_extensions = ["colon_fence", "dollarmath", "deflist"]
myst_heading_anchors = 4
root_doc = "index"
exclude_patterns = []

autodoc_typehints = "description"
napoleon_use_ivar = True  # attributes of a docstring are members, too
suppress_warnings = ["ref.python"]  # what a package also has under its own name
autodoc_member_order = "bysource"
breathe_projects = {"mesh_map": "reference/doxygen/xml"}
breathe_default_project = "mesh_map"
breathe_domain_by_extension = {"h": "cpp"}

html_theme = "furo"
html_title = "Mesh Tools"
html_math_renderer = mathml.RENDERER
graphviz_output_format = "svg"
copybutton_prompt_text = "$ "


def setup(app):
    """Docstrings are written for readers of the sources."""
    app.connect("autodoc-process-docstring", docstrings.prepare, priority=400)
