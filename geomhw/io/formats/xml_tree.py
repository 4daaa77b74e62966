"""XML as VTK and GIFTI have it: elements and attributes without a document type, so that no entity can expand."""

import re
from typing import NoReturn
from xml.etree.ElementTree import Element, TreeBuilder, XMLParser

#: Characters that an XML attribute cannot hold [XML 1.0, sec. 2.2 and 3.3.3]: control characters, single surrogates.
UNWRITABLE = re.compile("[\x00-\x1f\ud800-\udfff\ufffe\uffff]")
#: Parsing takes 28 bytes of memory for each byte of an attribute.
LONGEST_TAG = 1 << 16
#: Begin and end of what may hold any text.
_PLAIN = {b"<!--": b"-->", b"<![CDATA[": b"]]>"}
_TAG = re.compile(rb"<(?:[^>\"']+|\"[^\"]*\"?|'[^']*'?)*")
#: A VTK file has a few elements an array, a series one a frame; each takes a hundred bytes of memory and more.
MOST_TAGS, LEAST_BYTES_A_TAG = 1000, 32


def parse_xml(data: bytes) -> Element:
    """Return the root element; ParseError if the data are not XML, ValueError if they are not XML of this kind."""
    if (tags := data.count(b"<")) > MOST_TAGS and tags * LEAST_BYTES_A_TAG > len(data):
        raise ValueError(f"{tags} tags in {len(data)} bytes are no data")
    begin = data.find(b"<")
    while begin >= 0:
        if closing := next((last for first, last in _PLAIN.items() if data.startswith(first, begin)), None):
            end = data.find(closing, begin)
            end = len(data) if end < 0 else end
        else:
            end = _TAG.match(data, begin, begin + LONGEST_TAG + 1).end()  # type: ignore[union-attr]
            if end - begin > LONGEST_TAG:
                raise ValueError(f"it has a tag of more than {LONGEST_TAG} bytes")
        begin = data.find(b"<", end)
    parser = XMLParser(target=_WithoutDocumentType())
    try:
        parser.feed(data)
        root: Element = parser.close()
    except LookupError as error:  # its first line names an encoding that does not exist
        raise ValueError(str(error)) from None
    return root


class _WithoutDocumentType(TreeBuilder):
    """A tree that refuses a document type."""

    def doctype(self, name: str, pubid: str | None, system: str | None) -> NoReturn:
        """Raise before the declarations of the document type are read."""
        raise ValueError("it has a document type with declarations, which no mesh file needs")
