"""Text for people."""


def one_line(text: object) -> str:
    """The text on one line, with all that it says: line breaks and tabs become spaces, what else
    cannot be seen is written as in Python (\\x07, \\u200d, \\udcff for a byte that is no UTF-8)."""
    whole = str(text)
    if not whole.isprintable():
        whole = "".join(map(_seen, whole))
    return whole.strip()


def read_more(package: str, page: str) -> str:
    """What the help of a node or a command ends with: where more of it is told.

    Args:
        package: whose README.md tells more; it lies beside package.xml, in the source tree as where
            it is installed.
        page: of the reference on the site, with its anchor.
    """
    return (
        "More:\n"
        "  $(rospack find %s)/README.md\n"
        "  build/docs/html/reference/%s, which ./run docs makes in the source tree\n"
        % (package, page)
    )


def _seen(character):
    if character.isprintable():
        return character
    return " " if character in "\t\n\v\f\r" else ascii(character)[1:-1]
