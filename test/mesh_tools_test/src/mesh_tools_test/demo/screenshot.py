"""A picture of RViz as a user sees it, from a virtual screen."""
import time

import numpy as np
from PIL import ImageGrab

from mesh_tools_test.demo.processes import DemoError, wait_until

STATUS_BAR = 32  # pixels at the lower edge of RViz's window
RIGHT_EDGE = 32  # pixels of a closed dock
COLORED = 0.02  # of the scene; paths, goal and robot alone draw less
GREY = 40  # largest difference between the channels of a color that is none


def grab(environment):
    """The whole virtual screen as an RGB image."""
    return ImageGrab.grab(xdisplay=environment["DISPLAY"]).convert("RGB")


def window_of(picture):
    """The part of a picture (H,W,3) of the screen that is a window at its upper left corner; all
    beside it is black."""
    drawn = picture.any(axis=2)
    height, width = (np.flatnonzero(drawn.any(axis=axis)).max(initial=-1) + 1 for axis in (1, 0))
    return picture[:height, :width]


def scene(picture):
    """The right half of RViz's window: 3D view only, without the tree of displays."""
    return picture[picture.shape[0] // 4 :, picture.shape[1] // 2 : -RIGHT_EDGE]


def view_of(picture, background):
    """The part of a picture (H,W,3) of RViz that is its 3D view, whose edges have a color."""
    rows, columns = np.nonzero((picture == np.array(background, dtype=np.uint8)).all(axis=2))
    if len(rows) == 0:
        raise DemoError(f"RViz shows no background in {background}: its 3D view is not there")
    return picture[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]


def drawn_share(pixels):
    """The share of the pixels (H,W,3) that are not of the most frequent color, 0 to 1."""
    packed = pixels.astype(np.uint32) @ np.array([1 << 16, 1 << 8, 1], dtype=np.uint32)
    _, counts = np.unique(packed, return_counts=True)
    return 1.0 - counts.max() / packed.size


def colored_share(pixels):
    """The share of the pixels (H,W,3) that are not grey, 0 to 1: those of a mesh with its costs.

    RViz draws a mesh in grey until its costs come.
    """
    return float((np.ptp(pixels, axis=2) > GREY).mean())


def settled_picture(environment, rviz, timeout=90.0, still=1.5, still_when_grey=10.0):
    """Wait until RViz draws something and its picture stays the same; return it as an image.

    :param rviz: (name, process, log file) of the program
    :param still: how long the picture must not change [s]
    :param still_when_grey: the same where so little is colored that the costs may yet come [s]
    """
    last, since = None, time.monotonic()

    def unchanged():
        nonlocal last, since
        picture = window_of(np.asarray(grab(environment)))[:-STATUS_BAR]  # without the frame rate
        if not picture.size:
            return False
        if last is None or not np.array_equal(picture, last):
            last, since = picture, time.monotonic()
        pixels = scene(picture)
        wanted = still if colored_share(pixels) > COLORED else still_when_grey
        return drawn_share(pixels) > 0 and time.monotonic() - since > wanted

    wait_until(unchanged, timeout, "a finished picture in RViz", [rviz])
    return grab(environment)
