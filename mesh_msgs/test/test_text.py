"""Texts of strangers on one line of a terminal or log."""

import sys

from mesh_msgs.text import one_line


def test_nothing_is_hidden():
    assert one_line("  Bäume 木\n\tand\r\n more ") == "Bäume 木  and   more"
    assert one_line("a\x1b[2J\x07\x7f\x85") == "a\\x1b[2J\\x07\\x7f\\x85"
    assert one_line("\u00a0a\u200b\u202eb\u2028\ufeff") == "\\xa0a\\u200b\\u202eb\\u2028\\ufeff"
    assert one_line("caf\udce9") == "caf\\udce9"
    assert one_line("\U000e0001") == "\\U000e0001"
    assert one_line(ValueError("no\nfile")) == "no file" and one_line("") == ""


def test_different_characters_look_different():
    shown = {one_line("x%sx" % chr(code)) for code in range(32, sys.maxunicode + 1)}
    assert len(shown) == sys.maxunicode + 1 - 32
    assert all(text.isprintable() for text in shown)
    assert len({one_line("x%sx" % chr(code)) for code in range(32)}) == 32 - 4  # five are a space
