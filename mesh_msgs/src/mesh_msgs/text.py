"""Text for people."""


def one_line(text: object) -> str:
    """The text on one line, with all that it says: line breaks and tabs become spaces, what else
    cannot be seen is written as in Python (\\x07, \\u200d, \\udcff for a byte that is no UTF-8)."""
    whole = str(text)
    if not whole.isprintable():
        whole = "".join(map(_seen, whole))
    return whole.strip()


def _seen(character):
    if character.isprintable():
        return character
    return " " if character in "\t\n\v\f\r" else ascii(character)[1:-1]
