"""What the tables of READMEs say of names, defaults and ranges."""
import math
import re
from typing import Any, Iterable, List, NamedTuple, Optional, Set, Tuple

import yaml
from mesh_map.base.parameter import Parameter

from mesh_tools_test.reference.names_in_code import ACTION, PARAMETER, SERVICE, TOPIC
from mesh_tools_test.reference.readme_tables import Cell, Table

_KINDS = {"parameter": PARAMETER, "service": SERVICE, "action": ACTION}
_TOPICS = ("topic", "published", "subscribed")
_RANGE = re.compile(r"\[([^\[\],]+), ([^\[\],]+)([\])])")
_IN_WORDS = re.compile(r"(-?[\d.]*\d) to (-?[\d.]*\d)")
_UNIT = re.compile(r"(?<=\d)\s*(?:s|m|m/s|rad|°|Hz)$")
_WORDS = {
    "empty": "",
    "none": (),
    "inf": math.inf,
    "-inf": -math.inf,
    "∞": math.inf,
    "π/18": math.pi / 18,
}
_NAME = re.compile(r"~?[<>\w/]+$")


def normal(name: str) -> str:
    """A name without what is before it: ~, /, the namespace, a placeholder."""
    return re.sub(r"^(?:<[^>]*>|[~/])+", "", name)


def kind_of(table: Table) -> Optional[str]:
    """What the first column of a table names: topics, services, ...; None for something else."""
    first = table.header[0].split(" ")[0].strip(",") if table.header[0] else ""
    return TOPIC if first in _TOPICS else _KINDS.get(first)


def documented(tables: Iterable[Table], kind: str) -> Set[str]:
    """The names in the first column of those tables that are about a kind."""
    found: Set[str] = set()
    for table in tables:
        if kind_of(table) == kind:
            for row in table.rows:
                found |= {normal(code) for code in row[0].codes if _NAME.match(code)}
    return found - {""}


class Claim(NamedTuple):
    """What a row says of a parameter; default, low, high are None where it does not say it."""

    name: str
    default: Any
    low: Optional[float]
    high: Optional[float]


def _value(text: str) -> Any:
    """What a default means; None for words that are none."""
    text = re.sub(r" \([^)]*\)$", "", text.strip())  # what it means
    text = text.strip("`").replace("−", "-").rstrip(";,").strip()
    text = _UNIT.sub("", text)
    if text in _WORDS:
        return _WORDS[text]
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError:
        return None
    return tuple(value) if isinstance(value, list) else value


def _range(text: str) -> Tuple[str, Optional[float], Optional[float]]:
    """A text without the range at its end, and the range."""
    found = None
    for found in _RANGE.finditer(text):
        pass
    if found is None or text[: found.start()].strip() == "":
        return text, None, None
    low, high = _value(found.group(1)), _value(found.group(2))
    return text[: found.start()], low, high


def claims_of_columns(table: Table) -> List[Claim]:
    """Of a table with a column of names and one of defaults, [low, high] behind them, or in the
    third column "low to high", for all names of the row or for each."""
    claims = []
    for row in table.rows:
        names = [normal(code) for code in row[0].codes if _NAME.match(code)]
        text, low, high = _range(row[1].text)
        values = re.split(r", (?![^\[]*\])", re.sub(r" \([^)]*\)$", "", text))
        if len(values) == 1:
            values = values * len(names)
        ranges: List[Tuple[Optional[float], Optional[float]]] = [(low, high)]
        if low is None and len(row) > 2:
            found = _IN_WORDS.findall(row[2].text.replace("−", "-"))
            ranges = [(float(one), float(other)) for one, other in found] or ranges
        if len(ranges) == 1:
            ranges = ranges * len(names)
        ranges += [(None, None)] * (len(names) - len(ranges))
        for name, value, (low, high) in zip(names, values, ranges):
            claims.append(Claim(name, _value(value), low, high))
    return claims


def claims_of_cell(cell: Cell) -> List[Claim]:
    """Of a cell that is a list: `name` default [low, high], ..."""
    claims = []
    parts = re.split(r"(?:^|[,;:] )(?=`[a-z_]+`)", cell.text)
    for part in parts:
        found = re.match(r"`([a-z_]+)`(.*)", part)
        if found:
            text, low, high = _range(re.sub(r" \([^)]*\)", "", found.group(2)))
            claims.append(Claim(found.group(1), _value(text.strip() or "~"), low, high))
    return claims


def differences(claim: Claim, parameter: Parameter) -> List[str]:
    """What a claim says that is not so, the end of a sentence each."""
    wrong = []
    in_words = isinstance(claim.default, str) and parameter.default in ("", ())  # of an empty one
    if claim.default is not None and not in_words and not _same(claim.default, parameter.default):
        wrong.append("has the default %r, which is %r" % (claim.default, parameter.default))
    for text, said, is_so in (
        ("lowest", claim.low, parameter.minimum),
        ("highest", claim.high, parameter.maximum),
    ):
        if said is not None and not _same(said, is_so):
            wrong.append("has the %s value %r, which is %r" % (text, said, is_so))
    return wrong


def _same(said: Any, is_so: Any) -> bool:
    if is_so is None:
        is_so = math.inf
    numbers = (int, float)
    if isinstance(said, numbers) and isinstance(is_so, numbers):
        return isinstance(said, bool) == isinstance(is_so, bool) and math.isclose(said, is_so)
    return said == is_so or said in ((), {}) and is_so in ((), "", {})
