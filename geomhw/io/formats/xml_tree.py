"""XML as VTK writes it: elements and attributes, no document type, hence no entities that grow."""

import re
from typing import NoReturn
from xml.etree.ElementTree import Element, TreeBuilder, XMLParser

#: What does not come back from an XML attribute [XML 1.0, sec. 2.2 and 3.3.3]: control characters, half of a pair.
UNWRITABLE = re.compile("[\x00-\x1f\ud800-\udfff\ufffe\uffff]")
#: A VTK file has a handful of elements an array, a series one a frame; each costs a hundred bytes of memory and more.
MOST_TAGS, LEAST_BYTES_A_TAG = 1000, 32


def parse_xml(data: bytes) -> Element:
    """The root element; ParseError where it is no XML, ValueError where it is not of the kind that is read here."""
    if (tags := data.count(b"<")) > MOST_TAGS and tags * LEAST_BYTES_A_TAG > len(data):
        raise ValueError(f"{tags} tags in {len(data)} bytes are no data")
    parser = XMLParser(target=_Plain())
    parser.feed(data)
    root: Element = parser.close()
    return root


class _Plain(TreeBuilder):
    """A tree without a document type."""

    def doctype(self, name: str, pubid: str | None, system: str | None) -> NoReturn:
        """Refuse one where it starts, before what it declares is read."""
        raise ValueError("it has a document type, which no VTK file has")
