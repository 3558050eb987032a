"""Where the widgets of a Qt program are on its screen, whatever fonts and sizes they have."""
from typing import Dict, List, NamedTuple, Optional

import numpy as np

POPUPS = {"popup": "QComboBox QAbstractItemView", "menu": "QMenu"}
ENOUGH = 40  # pixels: fewer are what peeps out below another window


class Box(NamedTuple):
    """Columns and rows of the screen; the last ones belong to it."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def middle(self):
        """Column and row."""
        return (self.left + self.right) // 2, (self.top + self.bottom) // 2

    @property
    def height(self):
        """In pixels."""
        return self.bottom - self.top + 1


def packed(picture) -> np.ndarray:
    """An RGBA picture with a number for each pixel: one comparison, and not four."""
    return np.ascontiguousarray(picture).view("<u4")[:, :, 0]


class Widgets:
    """A style sheet, to be given to the program as -stylesheet, gives each a color of its own.

    :param selectors: name -> selector of Qt's style sheets; one that ends with ":enabled" is that
        of widgets which are found only while they can be used. "popup" (of a combo box) and "menu"
        are there anyway
    """

    def __init__(self, selectors: Dict[str, str]) -> None:
        self._selectors = {**POPUPS, **selectors}
        assert len(self._selectors) < 125, "two widgets would have one color"
        self._colors = {
            name: (253, 5 + 2 * i, 97 * i % 251) for i, name in enumerate(self._selectors)
        }

    def style_sheet(self) -> str:
        """Its text."""
        return "".join(
            f"{selector} {{ background-color: rgb{color}; selection-background-color: rgb{color};"
            # Chosen entries of popups have the color of what they pop out of.
            f" border: {3 if name in POPUPS else 0}px solid rgb{color};"
            " min-width: 14px; min-height: 14px; }\n"
            for (name, selector), color in zip(self._selectors.items(), self._colors.values())
        )

    def _mask(self, picture: np.ndarray, name: str) -> np.ndarray:
        red, green, blue = self._colors[name]
        return picture == np.uint32(red | green << 8 | blue << 16 | 255 << 24)

    def box(self, picture: np.ndarray, name: str) -> Optional[Box]:
        """Where it is in a packed picture; None where it is not there, disabled or hidden."""
        mask = self._mask(picture, name)
        if np.count_nonzero(mask) < ENOUGH:
            return None
        rows, columns = (np.flatnonzero(mask.any(axis=axis)).tolist() for axis in (1, 0))
        return Box(columns[0], rows[0], columns[-1], rows[-1])

    def pieces(self, picture: np.ndarray, name: str) -> List[Box]:
        """Where those are that have one name and stand one below the other."""
        mask = self._mask(picture, name)
        columns = np.flatnonzero(mask.any(axis=0)).tolist()
        edges = np.flatnonzero(np.diff(np.r_[0, mask.any(axis=1).astype(int), 0])).tolist()
        return [
            Box(columns[0], begin, columns[-1], end - 1)
            for begin, end in zip(edges[::2], edges[1::2])
        ]
