"""What a server keeps for good costs no time; what it gives up is found."""

import gc
import os
import subprocess
import sys
import weakref

import pytest

from mesh_navigation.server.settled_memory import settle

# Arrays of 4 MiB that are freed, and smaller ones between them that stay.
ARRAYS = """
import numpy as np
from mesh_navigation.server.settled_memory import give_back_large_arrays

def anonymous():
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("RssAnon"))

assert give_back_large_arrays()
kept, before = [], anonymous()
for _ in range(3):
    large = []
    for _ in range(50):
        large.append(np.ones(1 << 22, np.uint8))
        kept.append(np.ones(1 << 16, np.uint8))
    del large
print(anonymous() - before)
"""


class Loop:
    """Garbage that only a collection finds."""

    def __init__(self):
        self.itself = self


@pytest.fixture(autouse=True)
def unfrozen():
    yield
    gc.unfreeze()


def test_what_is_there_is_not_looked_at_again():
    kept = [[] for _ in range(1000)]
    settle()
    assert gc.get_freeze_count() > len(kept)
    looked_at = {id(thing) for thing in gc.get_objects()}
    assert not looked_at & {id(thing) for thing in kept}


def test_what_comes_later_is_collected_as_ever():
    settle()
    loop = Loop()
    gone = weakref.ref(loop)
    del loop
    gc.collect()
    assert gone() is None


def test_settling_again_finds_what_was_given_up():
    loop = Loop()
    settle()
    gone = weakref.ref(loop)
    del loop
    settle()
    assert gone() is None


@pytest.mark.skipif("LD_PRELOAD" in os.environ, reason="may have another malloc than glibc's")
def test_large_arrays_go_back_to_the_system():
    left = subprocess.run([sys.executable, "-c", ARRAYS], check=True, stdout=subprocess.PIPE)
    assert int(left.stdout) < 40 << 10  # KiB; 130 MiB and more if it is not asked for
