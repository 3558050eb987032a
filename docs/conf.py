"""Sphinx's settings of the site; `./run docs` calls it on a copy of this folder with what is made of the code."""
import os

project = "Mesh Tools"
author = "Mesh Tools developers"
copyright = author
version = release = os.environ.get("MESH_TOOLS_VERSION", "")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinxcontrib.mermaid",
    "sphinx_copybutton",
    "breathe",
]
myst_enable_extensions = ["colon_fence", "dollarmath", "deflist"]
myst_heading_anchors = 4
myst_fence_as_directive = ["mermaid"]
root_doc = "index"
exclude_patterns = []

autodoc_typehints = "description"
autodoc_member_order = "bysource"
breathe_projects = {"mesh_map_core": os.path.abspath("doxygen/xml")}
breathe_default_project = "mesh_map_core"

html_theme = "furo"
html_title = "Mesh Tools"
copybutton_prompt_text = "$ "
