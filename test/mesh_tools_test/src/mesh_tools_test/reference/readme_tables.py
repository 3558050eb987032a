"""The tables of READMEs."""
from pathlib import Path
from typing import Iterator, List, NamedTuple, Tuple

from markdown_it import MarkdownIt


class Cell(NamedTuple):
    """Of a table: its Markdown, and what in it is in the letters of a program."""

    text: str
    codes: Tuple[str, ...]


class Table(NamedTuple):
    """A table, and the headings that it is below, from the top one down."""

    headings: Tuple[str, ...]
    header: Tuple[str, ...]
    rows: Tuple[Tuple[Cell, ...], ...]


def _cell(inline) -> Cell:
    codes = tuple(one.content for one in inline.children or () if one.type == "code_inline")
    return Cell(inline.content, codes)


def read_tables(text: str) -> Iterator[Table]:
    """Those of a Markdown text, in their order."""
    tokens = MarkdownIt("commonmark").enable("table").parse(text)
    headings: List[Tuple[int, str]] = []
    rows: List[List[Cell]] = []
    for token, following in zip(tokens, [*tokens[1:], tokens[-1]] if tokens else []):
        if token.type == "heading_open":
            level = int(token.tag[1:])
            headings = [one for one in headings if one[0] < level]
            headings.append((level, following.content))
        elif token.type == "table_open":
            rows = []
        elif token.type == "tr_open":
            rows.append([])
        elif token.type in ("th_open", "td_open"):
            rows[-1].append(_cell(following))
        elif token.type == "table_close":
            header = tuple(cell.text for cell in rows[0])
            yield Table(tuple(text for _, text in headings), header, tuple(map(tuple, rows[1:])))


def tables_of(path: Path) -> List[Table]:
    """Those of a file."""
    return list(read_tables(path.read_text(encoding="utf-8")))
