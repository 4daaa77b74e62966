"""Damaged and hostile files of GIFTI and FreeSurfer: one sentence each, within the limits of the other readers."""

import base64
import gzip
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fuzz.targets import feed
from geomhw.errors import FieldError
from geomhw.io import read_field
from geomhw.mesh.triangle_mesh import TriangleMesh
from support.messages import missing
from support.neuro_files import FACES, LABEL_TEXT, POINTS, border_text, labels, metric, quads, surface

CORPUS = Path(__file__).parents[1] / "fuzz" / "corpus"
TEXT = (CORPUS / "gii" / "ASCII.gii").read_bytes()
BINARY = (CORPUS / "gii" / "B64BIN.gii").read_bytes()
PACKED = (CORPUS / "gii" / "B64GZ.gii").read_bytes()
ENTITIES = b'<!DOCTYPE GIFTI [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;">]>'
BOMB = base64.b64encode(zlib.compress(bytes(1 << 24), 9))


def between(data: bytes, new: bytes) -> bytes:
    """The file with other contents of its first array."""
    begin, end = data.index(b"<Data>") + 6, data.index(b"</Data>")
    return data[:begin] + new + data[end:]


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (TEXT[:-200], "not a whole GIFTI file"),
        (TEXT.replace(b"<GIFTI", ENTITIES + b"<GIFTI", 1), "document type"),
        (TEXT.replace(b'Dim0="4"', b'Dim0="5"'), "array 0 has 12 numbers where it says 15"),
        (BINARY.replace(b'Dim0="4"', b'Dim0="4000000000"'), "array 0 of 48 bytes says that it unpacks to"),
        (BINARY.replace(b'Dim0="4"', b'Dim0="-4"'), "shape [-4, 3]"),
        (BINARY.replace(b'Dim1="3"', b'Dim1="0"'), "shape"),
        (BINARY.replace(b"FLOAT32", b"COMPLEX64"), "type COMPLEX64"),
        (BINARY.replace(b"Base64Binary", b"ExternalFileBinary"), "ExternalFileBinary ... known are"),
        (between(BINARY, b"!" * 64), "base64 text holds a character"),
        (between(BINARY, b"AAAA"), "array 0 has 0.75 numbers where it says 12"),
        (between(PACKED, b"AAAA"), "not a whole GIFTI file"),
        (between(PACKED, BOMB), "numbers where it says 12"),
        (between(TEXT, b"1 2 x"), "not a number"),
        (TEXT.replace(b"TRIANGLE", b"NORMAL"), "holds arrays and no triangles"),
        (TEXT.replace(b"TRIANGLE", b"POINTSET"), "two surfaces"),
        (TEXT.replace(b"TRIANGLE", b"NODE_INDEX"), "listed vertices only"),
        (between(TEXT, b" 0 0 nan" * 4), "finite"),
        (gzip.compress(bytes(1 << 28))[:-4], "unpacks to"),
        (gzip.compress(TEXT)[:-100], "ends early"),
        (b'<?xml version="1.0" encoding="quux"?>' + TEXT[TEXT.index(b"<GIFTI") :], "unknown encoding"),
        (b"<GIFTI>" + b"<DataArray/>" * 100_000 + b"</GIFTI>", "tags"),
    ],
)
def test_gifti_is_refused(data: bytes, words: str) -> None:
    """Truncated files, wrong counts, wrong encodings, entities and bombs are refused with the reason."""
    assert not missing(feed("gii", data) or "", words)


TRIANGLES = (CORPUS / "freesurfer" / "triangles").read_bytes()
AT = TRIANGLES.index(b"\n\n") + 2


@pytest.mark.parametrize(
    ("target", "data", "words"),
    [
        ("freesurfer", TRIANGLES[: AT + 20], "needs ... bytes and has"),
        ("freesurfer", TRIANGLES[:AT] + b"\x7f" + TRIANGLES[AT + 1 :], "needs ... bytes and has"),
        ("freesurfer", TRIANGLES[:AT] + b"\xff" + TRIANGLES[AT + 1 :], "a count is -"),
        ("freesurfer", quads()[:-1], "needs ... bytes and has"),
        ("freesurfer", b"\xff\xff\xfeno end", "first line"),
        ("freesurfer", b"\0\0\0no mark", "first three bytes"),
        ("label", LABEL_TEXT.replace(b"\n3  ", b"\n7  "), "names vertex 7; the mesh has 4 vertices"),
        ("label", LABEL_TEXT.replace(b"\n2\n", b"\n3\n"), "says 3 vertices and has 2 lines"),
        ("annot", (CORPUS / "annot" / "lh.annot").read_bytes()[:-9], "needs ... bytes and has"),
        ("annot", (CORPUS / "annot" / "lh.annot").read_bytes()[:36], "needs ... bytes and has"),
        ("mgh", (CORPUS / "mgh" / "a.mgh").read_bytes()[:290], "needs ... bytes and has"),
        ("mgz", (CORPUS / "mgz" / "a.mgz").read_bytes()[:-9], "ends early"),
        ("mgz", gzip.compress(bytes(1 << 28)), "unpacks to"),
        ("curv", b"no file of FreeSurfer", "no arrays are read from '.thickness' ... FreeSurfer"),
    ],
)
def test_freesurfer_is_refused(target: str, data: bytes, words: str) -> None:
    """Truncated files and wrong counts are refused with the reason."""
    assert not missing(feed(target, data) or "", words)


@pytest.mark.parametrize(
    ("image", "key", "words"),
    [
        (lambda: metric(np.zeros(4, "f4"), np.ones(4, "f4")), "", "say which array ... map 0, map 1"),
        (lambda: metric(np.zeros(4, "f4")), ":2", "no array or label '2'; there are map 0"),
        (labels, ":postcentral", "no array or label 'postcentral' ... areas ... precentral ... medial wall"),
        (lambda: metric(np.zeros(5, "f4")), "", "5 rows; the mesh has 4 vertices"),
        (lambda: metric(np.array([0, np.nan, 0, 0], "f4")), "", "row 1 is not a finite number"),
        (surface, "", "holds none"),
    ],
)
def test_arrays_are_named(image: Callable[[], object], key: str, words: str, tmp_path: Path) -> None:
    """Messages about arrays of GIFTI list those that exist."""
    image().to_filename(tmp_path / "a.func.gii")  # type: ignore[attr-defined]
    with pytest.raises(FieldError) as caught:
        read_field(f"{tmp_path}/a.func.gii{key}", TriangleMesh(POINTS, FACES))
    assert not missing(str(caught.value), words)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (border_text().replace('Version="3"', 'Version="1"'), "version 1 ... -border-merge"),
        (border_text().replace('Vertices="4"', 'Vertices="5"'), "surface of 5 vertices ... mesh has 4"),
        (border_text().replace("BorderFile", "Borders"), "no border file ... Borders"),
        (border_text("0 1 4", "1 1 1"), "damaged ... vertex 4"),
        (border_text("0 1 -1", "1 1 1"), "damaged ... vertex -1"),
        (border_text("0 1 2", "0.5 -0.5 1"), "damaged ... negative"),
        (border_text("0 1 2", "0 0 0"), "damaged ... all zero"),
        (border_text("0 1 2", "nan 0 1"), "damaged ... not finite"),
        (border_text("0 1", "0 0"), "three for each point"),
        (border_text("0 1 2", "1 1 1\n1 1 1"), "1 points and 2 weights"),
        (border_text("0 1 x", "1 1 1"), "damaged ... not a number"),
        (border_text()[:300], "damaged"),
        ('<BorderFile Version="3" SurfaceNumberOfVertices="4"/>', "holds no border"),
    ],
)
def test_borders_are_refused(text: str, words: str) -> None:
    """Borders of another version or surface, and damaged ones, are refused with the reason."""
    assert not missing(feed("border", text.encode()) or "", words)
