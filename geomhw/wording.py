"""Words of messages and reports: numbers with their nouns."""


def counted(count: int, noun: str, plural: str = "") -> str:
    """Return a number with a noun, by default with an s in the plural.

    Examples
    --------
    >>> counted(1, "vertex", "vertices"), counted(2, "face")
    ('1 vertex', '2 faces')
    """
    return f"{count} {noun if count == 1 else plural or noun + 's'}"
