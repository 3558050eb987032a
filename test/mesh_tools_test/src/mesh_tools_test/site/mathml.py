"""Formulas as MathML, which browsers draw themselves: an extension of Sphinx.

MathJax, which Sphinx takes by default, is fetched from the network.
"""
from typing import Any, Dict

from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging

RENDERER = "mathml"
_LOG = logging.getLogger(__name__)


def _formula(node: Any, inline: bool) -> str:
    """What is no formula here is a warning, and stands as it is."""
    try:
        return tex2mathml(node.astext(), inline=inline)
    except SyntaxError as error:
        _LOG.warning("%s (in %s)", error, node.astext(), location=node)
        return node.astext()


def _inline(translator: Any, node: Any) -> None:
    translator.body.append(_formula(node, inline=True))
    raise SkipNode


def _block(translator: Any, node: Any) -> None:
    translator.body.append(translator.starttag(node, "div", CLASS="math"))
    translator.body.append(_formula(node, inline=False) + "</div>\n")
    raise SkipNode


def setup(app: Any) -> Dict[str, Any]:
    """To be chosen by html_math_renderer = RENDERER."""
    app.add_html_math_renderer(RENDERER, (_inline, None), (_block, None))
    return {"parallel_read_safe": True}
