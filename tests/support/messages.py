"""Checks of a message by its keywords and numbers, not by its sentence."""


def missing(message: str, keywords: str) -> list[str]:
    """Return the keywords that a message lacks; they are given as one text, with `` ... `` between them."""
    return [keyword for keyword in keywords.split(" ... ") if keyword not in message]
