"""Findings, and the checks on arrays that the validators of all message types are made of."""

import inspect
from typing import Any, Callable, Iterable, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from mesh_msgs.wire.array_field import array_of


class Finding(NamedTuple):
    """One fault of a message; str() is a sentence for a user.

    Attributes:
        rule: stable name of the rule that is broken.
        what: what is wrong, with the first index and the number of cases.
        index: first index, None where the fault has no place in an array.
        count: number of cases.
        hint: the way out.
    """

    rule: str
    what: str
    index: Optional[int]
    count: int
    hint: str

    def __str__(self) -> str:
        return "%s; %s" % (self.what, self.hint)


Check = Callable[..., List[Finding]]


def as_array(
    name: str, value: Any, columns: Optional[int], attributes: Sequence[str] = ()
) -> Tuple[np.ndarray, List[Finding]]:
    """A member of an array message or a stock one as an array of shape (N,) or (N, columns).

    Returns:
        The array, and a finding if there is none to be made; the array is empty then.
    """
    shape = (0,) if columns is None else (0, columns)
    try:
        array = array_of(value, tuple(attributes))
    except (ValueError, TypeError, AttributeError) as error:
        return np.zeros(shape), [_shape_finding(name, shape, "no array: %s" % error)]
    if array.shape == (0,):
        return np.zeros(shape), []
    if array.ndim != len(shape) or array.shape[1:] != shape[1:] or array.dtype.kind not in "fiu":
        given = "shape %s and type %s" % (array.shape, array.dtype)
        return np.zeros(shape), [_shape_finding(name, shape, given)]
    return array, []


def _shape_finding(name: str, shape: Tuple[int, ...], given: str) -> Finding:
    wanted = "(N,)" if len(shape) == 1 else "(N, %d)" % shape[1]
    what = "%s should be numbers of shape %s, but is of %s" % (name, wanted, given)
    return Finding("array_shape", what, None, 1, "give an array of that shape")


def narrowed(array: np.ndarray) -> np.ndarray:
    """The array as float32, which is what renderers and planners work with: 1e60 becomes inf."""
    with np.errstate(over="ignore", invalid="ignore"):
        return array.astype(np.float32, copy=False)


def check_finite(rule: str, noun: str, array: np.ndarray, hint: str) -> List[Finding]:
    """Every number is finite as float32."""
    finite = np.isfinite(narrowed(array))
    if finite.all():
        return []
    bad = ~(finite.all(axis=1) if finite.ndim > 1 else finite)
    return [_rows_finding(rule, noun, array, bad, "which is not finite as float32", hint)]


def check_where(
    rule: str, noun: str, array: np.ndarray, bad: np.ndarray, reason: str, hint: str
) -> List[Finding]:
    """No row is marked in `bad`, a bool for each row."""
    if not bad.any():
        return []
    return [_rows_finding(rule, noun, array, bad, reason, hint)]


def _rows_finding(
    rule: str, noun: str, array: np.ndarray, bad: np.ndarray, reason: str, hint: str
) -> Finding:
    first, count = int(np.argmax(bad)), int(np.count_nonzero(bad))
    value = ", ".join("%g" % number for number in np.atleast_1d(array[first]))
    value = value if array.ndim == 1 else "(%s)" % value
    what = "%s %d is %s, %s (%d in all)" % (noun, first, value, reason, count)
    return Finding(rule, what, first, count, hint)


def check_indices(
    rule: str, noun: str, target: str, indices: np.ndarray, limit: Optional[int], hint: str
) -> List[Finding]:
    """Every index is an integer from 0 to limit - 1; a limit of None is not known yet.

    Args:
        noun: what refers, e.g. "face".
        target: what is referred to, e.g. ("vertex", "vertices").
        indices: (N,) or (N, k).
    """
    if not indices.size:
        return []
    singular, plural = target.split("/")
    if indices.dtype.kind == "f":
        what = "indices of %s are of type %s" % (plural, indices.dtype)
        return [Finding(rule, what, 0, len(indices), "give integers")]
    if int(indices.min()) >= 0 and (limit is None or int(indices.max()) < limit):
        return []
    outside = indices < 0
    if limit is not None:
        outside |= indices >= limit
    rows = outside if outside.ndim == 1 else outside.any(axis=1)
    first, count = int(np.argmax(rows)), int(np.count_nonzero(rows))
    value = int(np.atleast_1d(indices[first])[np.argmax(np.atleast_1d(outside[first]))])
    known = "" if limit is None else ", but the mesh has %d %s" % (limit, plural)
    what = "%s %d refers to %s %d%s (%d in all)" % (noun, first, singular, value, known, count)
    return [Finding(rule, what, first, count, hint)]


def check_count(
    rule: str, noun: str, count: int, expected: Optional[int], per: str, hint: str
) -> List[Finding]:
    """As many items as there are vertices (faces, ...); None is not known yet."""
    if expected is None or count == expected:
        return []
    what = "there are %d %s for %d %s" % (count, noun, expected, per)
    return [Finding(rule, what, min(count, expected), abs(count - expected), hint)]


def shown(text: str) -> str:
    """Text of a message in quotes, on one line and not too long for a log."""
    return repr(text if len(text) <= 60 else text[:57] + "...")


def check_header(message: Any) -> List[Finding]:
    """The frame has a name."""
    if message.header.frame_id:
        return []
    hint = "fill in header.frame_id where the message is made, e.g. 'map'"
    return [Finding("frame_id_empty", "the message names no frame", None, 1, hint)]


def check_uuid(uuid: str, expected: Optional[str]) -> List[Finding]:
    """The message belongs to the geometry at hand; None: any."""
    if expected is None or uuid == expected:
        return []
    what = "the message belongs to the mesh %s, not to %s" % (shown(uuid), shown(expected))
    hint = "wait for the geometry of that UUID, or publish the attribute again for this one"
    return [Finding("uuid_mismatch", what, None, 1, hint)]


def each(noun: str, items: Iterable[Any], check: Check) -> List[Finding]:
    """The findings of a check about each of some items, with the number of the item."""
    return [
        finding._replace(what="%s %d: %s" % (noun, number, finding.what), index=number)
        for number, item in enumerate(items)
        for finding in check(item)
    ]


def stamped(member: str, check: Check) -> Check:
    """The check of a message with a header (and UUID, if it has one) around a member.

    Its findings are those of the check of the member, frame_id_empty and uuid_mismatch. Its
    arguments are the message, those of that check, and uuid: that of the mesh at hand, or None.
    """
    of_member = inspect.signature(check)
    uuid = inspect.Parameter("uuid", inspect.Parameter.POSITIONAL_OR_KEYWORD, default=None)
    signature = of_member.replace(parameters=[*of_member.parameters.values(), uuid])

    def check_stamped(*given: Any, **named: Any) -> List[Finding]:
        told = signature.bind(*given, **named).arguments
        msg, expected = told.pop("msg"), told.pop("uuid", None)
        findings = check(getattr(msg, member), **told) + check_header(msg)
        return findings + (check_uuid(msg.uuid, expected) if hasattr(msg, "uuid") else [])

    check_stamped.__signature__ = signature  # type: ignore[attr-defined]
    return check_stamped
