"""Rows of a table that are the same, found by sorting."""
from typing import Sequence, Tuple

import numpy as np

_MULTIPLIER = np.uint64(0x9E3779B97F4A7C15)  # odd, its bits as if by chance


def equal_rows(columns: Sequence[np.ndarray]) -> Tuple[np.ndarray, np.ndarray]:
    """(first row of each group (G,), the group of each row (N,)) of the columns (N,) of a table.

    Rows of one group are the same in every column; NaN equals nothing. Groups are in the order of
    their values, the first column first.
    """
    order = np.lexsort(columns[::-1])  # stable: the first of each group is the first in the table
    new = np.ones(len(order), bool)
    new[1:] = False
    for column in columns:
        ordered = column[order]
        new[1:] |= ordered[1:] != ordered[:-1]
    group = np.zeros(len(order), np.int64)
    group[order] = np.cumsum(new) - 1
    return order[new], group


def by_appearance(first: np.ndarray, group: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """The same groups in the order in which they come first."""
    order = np.argsort(first, kind="stable")
    number = np.zeros(len(order), np.int64)
    number[order] = np.arange(len(order))
    return first[order], number[group]


def is_repeated(rows: np.ndarray) -> np.ndarray:
    """(N,): which rows of a table (N, C) of uint32 are the same as one before."""
    repeated = np.zeros(len(rows), bool)
    sums = np.zeros(len(rows), np.uint64)
    for column in rows.T:  # what is the same has the same sum; almost nothing else has
        sums = (sums + column) * _MULTIPLIER
    ordered = np.sort(sums)
    again = ordered[1:][ordered[1:] == ordered[:-1]]
    if len(again):
        candidates = np.flatnonzero(np.isin(sums, again))
        first, group = equal_rows(rows[candidates].T)
        repeated[candidates] = first[group] != np.arange(len(group))
    return repeated
