"""Digests differ where their parts do, whatever these are."""

import hashlib

import numpy as np
from mesh_map.base.digest import digest

DIFFERENT = [
    (),
    ("",),
    ("a",),
    ("a", "b"),
    ("ab",),
    ("ä",),
    (np.zeros(0, np.uint32),),
    (np.zeros((0, 3), np.uint32),),
    (np.zeros((0, 3), np.float32),),
    (np.zeros(6, np.float32),),
    (np.zeros((2, 3), np.float32),),
    (np.zeros((2, 3), ">f4"),),
    (np.zeros((2, 3), np.int32),),
    (np.array(True),),
    (np.arange(6.0).reshape(2, 3),),
    (np.arange(6.0).reshape(2, 3).T,),
    (np.array([np.nan]),),
    (np.array([-0.0]),),
    (np.array([0.0]),),
    ("a", np.array([0.0])),
    (np.array([0.0]), "a"),
]


def test_different_parts_have_different_digests():
    digests = [digest(*parts) for parts in DIFFERENT]
    assert len(set(digests)) == len(DIFFERENT)
    assert all(len(found) == 32 and set(found) <= set("0123456789abcdef") for found in digests)


def test_equal_parts_have_equal_digests():
    """Wherever they are in memory: labels and costs come as views of larger arrays, too."""
    whole = np.arange(60, dtype=np.float32).reshape(6, 10)
    view = whole[::2, 1:7:3]
    assert not view.flags.c_contiguous and digest(view) == digest(view.copy())
    text = b"text 1;a<f4 (3, 2);" + view.tobytes()  # files are full of these: they have to stay
    assert digest("a", view) == hashlib.blake2b(text, digest_size=16).hexdigest()
