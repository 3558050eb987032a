"""Text for people."""


def one_line(text: object) -> str:
    """The text without line breaks, control characters and bytes that are no characters."""
    valid = str(text).encode("utf-8", "backslashreplace").decode("utf-8")
    return "".join(c if c.isprintable() else " " for c in valid).strip()
