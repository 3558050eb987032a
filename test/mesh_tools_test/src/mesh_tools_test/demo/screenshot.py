"""A picture of RViz as a user sees it, from a virtual screen."""
import time

import numpy as np
from PIL import ImageGrab

from mesh_tools_test.demo.processes import wait_until

STATUS_BAR = 32  # pixels at the lower edge of RViz's window


def grab(environment):
    """The whole virtual screen as an RGB image."""
    return ImageGrab.grab(xdisplay=environment["DISPLAY"]).convert("RGB")


def scene(picture):
    """The right half of RViz's window: 3D view only, without the tree of displays."""
    return picture[picture.shape[0] // 4 :, picture.shape[1] // 2 :]


def settled_picture(environment, rviz, timeout=90.0, still=1.5):
    """Wait until RViz draws something and its picture stays the same; return it as an image.

    :param rviz: (name, process, log file) of the program
    :param still: how long the picture must not change [s]
    """
    last, since = None, time.monotonic()

    def unchanged():
        nonlocal last, since
        picture = np.asarray(grab(environment))[:-STATUS_BAR]  # without the frame rate
        if last is None or not np.array_equal(picture, last):
            last, since = picture, time.monotonic()
        blank = len(np.unique(scene(picture)[::4, ::4].reshape(-1, 3), axis=0)) < 64
        return not blank and time.monotonic() - since > still

    wait_until(unchanged, timeout, "a finished picture in RViz", [rviz])
    return grab(environment)
