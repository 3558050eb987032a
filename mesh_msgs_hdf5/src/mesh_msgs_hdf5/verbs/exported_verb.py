"""A verb that a package exports."""
from typing import NamedTuple


class ExportedVerb(NamedTuple):
    """name: a word, or a verb and its action; module: what has it; help: one line."""

    name: str
    module: str
    package: str
    help: str
