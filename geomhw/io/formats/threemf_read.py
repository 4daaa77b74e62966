"""Reader of 3MF: the triangles of the objects that the build places, in the unit of the file.

Hand-written because trimesh needs lxml and networkx for it, and unpacks archives of any size. [3MF Core Specification]
"""

import io
import re
import zipfile
import zlib
from array import array
from dataclasses import dataclass, field
from typing import Any, NoReturn
from urllib.parse import unquote
from xml.parsers import expat

import numpy as np

from geomhw.arrays import Floats
from geomhw.errors import FormatError
from geomhw.io.formats.build_result import build_result
from geomhw.io.formats.polygons import Polygons
from geomhw.results import Result

#: Bytes that the model may have unpacked, for any file and for each packed byte.
_LEAST_LIMIT, _MOST_RATIO = 1 << 20, 100
#: Placed copies of objects, at most.
_MOST = 1 << 12
#: Copies of all objects together that the build may place.
_MOST_COPIES = 64
_BLOCK = 1 << 16
#: Target of the relationship that names the main model of an archive.
_MAIN = re.compile(r"<Relationship\b(?=[^>]*\bType=.[^\"']*/3dmodel[\"'])[^>]*\bTarget=[\"']([^\"']*)", re.IGNORECASE)
#: An object: the file that holds it, "" for the main model, and its number.
_Key = tuple[str, str]


@dataclass
class _Object:
    """A mesh, or parts that are other objects at their places."""

    name: str
    points: Any = field(default_factory=lambda: array("d"))
    corners: Any = field(default_factory=lambda: array("q"))
    parts: list[tuple[_Key, Floats]] = field(default_factory=list)


class _Model:
    """Handlers of the elements of one file of a model; elements of extensions, such as slices, are passed over."""

    def __init__(self, file: str) -> None:
        self.unit = "millimeter"
        self.objects: dict[_Key, _Object] = {}
        self.items: list[tuple[_Key, Floats]] = []
        self._file, self._now, self._space = file, _Object(""), ""
        self._parser = expat.ParserCreate(namespace_separator="}")
        self._parser.StartElementHandler = self._start
        self._parser.StartDoctypeDeclHandler = self._doctype
        self.feed = self._parser.Parse

    def _doctype(self, *_: Any) -> NoReturn:
        raise ValueError("it has a document type, which no model has")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        space, _, tag = tag.rpartition("}")
        if tag == "model":
            self.unit, self._space = attributes.get("unit", self.unit), space
        elif space != self._space:
            return
        elif tag == "vertex":
            self._now.points.extend([float(attributes[axis]) for axis in "xyz"])
        elif tag == "triangle":
            self._now.corners.extend([int(attributes[corner]) for corner in ("v1", "v2", "v3")])
        elif tag == "object":
            self._now = _Object(attributes.get("name") or f"object {attributes['id']}")
            self.objects[self._file, attributes["id"]] = self._now
        elif tag == "component":
            self._now.parts.append((self._key(attributes), _matrix(attributes)))
        elif tag == "item":
            self.items.append((self._key(attributes), _matrix(attributes)))

    def _key(self, attributes: dict[str, str]) -> _Key:
        """The object that a component or an item names, perhaps in another file [3MF Production Extension]."""
        path = next((value for name, value in attributes.items() if name.endswith("}path")), None)
        return self._file if path is None else _member(path), attributes["objectid"]


def _member(path: str) -> str:
    """Name of a file in an archive, which does not depend on case."""
    return unquote(path).lstrip("/").lower()


def _matrix(attributes: dict[str, str]) -> Floats:
    """A transform, (4, 3), of rows that are multiplied from the left."""
    numbers = np.array([float(number) for number in attributes.get("transform", "1 0 0 0 1 0 0 0 1 0 0 0").split()])
    if not np.isfinite(numbers).all():
        raise ValueError("a transform is not finite")
    return numbers.reshape(4, 3)


def read_3mf(name: str, data: bytes) -> Result:
    """Return the triangles of all items of the build."""
    try:
        model = _parsed(data)
        placed = _placed(model)
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, zlib.error) as error:
        raise FormatError(f"{name} is not a whole 3MF archive: {' '.join(str(error).split())[:120]}") from error
    except (expat.ExpatError, ValueError, KeyError, OverflowError) as error:
        reason = (
            f"an element has no attribute {error}"
            if isinstance(error, KeyError)
            else " ".join(str(error).split())[:120]
        )
        raise FormatError(f"{name} holds no whole 3MF model: {reason}") from error
    if not placed:
        raise FormatError(f"{name} holds no triangles")
    starts = np.cumsum([0, *(len(points) for _, points, _ in placed)])
    corners = np.concatenate([faces.ravel() + start for (_, _, faces), start in zip(placed, starts, strict=False)])
    titles = list(dict.fromkeys(title for title, _, _ in placed))
    arrays, labels = {}, {}
    if len(placed) > 1:
        numbers = np.arange(len(placed)) if len(titles) < len(placed) else [titles.index(t) for t, _, _ in placed]
        arrays["group"] = np.repeat(np.array(numbers, np.int32), [len(faces) for _, _, faces in placed])
        labels["group"] = {k: title for k, (title, _, _) in enumerate(placed)}
    points = np.concatenate([points for _, points, _ in placed])
    sizes = np.full(len(corners) // 3, 3)
    content = Polygons(points, corners, sizes, face_arrays=arrays, labels=labels, notes={"unit": model.unit})
    return build_result(name, "3MF", content)


def _parsed(data: bytes) -> _Model:
    """The main model of an archive, with the objects that it uses from other files."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = {_member(member.filename): member for member in archive.infolist()}
        left = _LEAST_LIMIT + _MOST_RATIO * len(data)
        main = _main_file(archive, members)
        model = _Model("")
        waiting, visited = [(main, model)], {"", main}
        while waiting:
            file, part = waiting.pop()
            with archive.open(members[file]) as stream:
                while block := stream.read(_BLOCK):
                    left -= len(block)
                    if left < 0:
                        raise zipfile.BadZipFile("its model unpacks to far more than it can hold")
                    part.feed(block, False)
            part.feed(b"", True)
            model.objects |= part.objects
            named = [key for thing in part.objects.values() for key, _ in thing.parts] + [key for key, _ in part.items]
            for file in dict.fromkeys(file for file, _ in named if file not in visited):
                if file not in members:
                    raise ValueError(f"it names the file '{file[:60]}', which the archive does not hold")
                visited.add(file)
                waiting.append((file, _Model(file)))
    return model


def _main_file(archive: zipfile.ZipFile, members: dict[str, zipfile.ZipInfo]) -> str:
    """Name of the main model: by the relationships of the archive, or its usual name."""
    named = []
    if relations := members.get("_rels/.rels"):
        with archive.open(relations) as stream:
            named = [_member(target) for target in _MAIN.findall(stream.read(_BLOCK).decode("utf-8", "replace"))]
    names = [*named, "3d/3dmodel.model", *(name for name in members if name.endswith(".model"))]
    found = [name for name in names if name in members]
    if not found:
        raise zipfile.BadZipFile("it holds no model")
    return found[0]


def _placed(model: _Model) -> list[tuple[str, Floats, Any]]:
    """Name, points and faces of each mesh that the build places; of all objects without a build."""
    identity = _matrix({})
    waiting = [(key, matrix, 0) for key, matrix in model.items or [(key, identity) for key in model.objects]]
    placed: list[tuple[str, Floats, Any]] = []
    visited, copied = 0, 0
    most = _MOST_COPIES * sum(len(thing.points) // 3 for thing in model.objects.values())
    while waiting:
        key, matrix, depth = waiting.pop(0)
        if key not in model.objects:
            raise ValueError(f"object {key[1][:40]} is named and does not exist")
        thing, visited = model.objects[key], visited + 1
        if depth > 64 or visited > _MOST:
            raise ValueError("its components form a circle, or are too many")
        for part, inner in thing.parts:
            with np.errstate(all="ignore"):
                waiting.append(
                    (part, np.concatenate([inner[:3] @ matrix[:3], inner[3:] @ matrix[:3] + matrix[3:]]), depth + 1)
                )
        if thing.corners:
            points = np.frombuffer(thing.points, dtype=float).reshape(-1, 3)
            faces = np.frombuffer(thing.corners, dtype=np.int64).reshape(-1, 3)
            if faces.min() < 0 or faces.max() >= len(points):
                raise ValueError(f"a triangle of {thing.name[:40]} names a vertex that does not exist")
            with np.errstate(all="ignore"):
                faces = faces[:, ::-1] if np.linalg.det(matrix[:3]) < 0 else faces
                moved = points if np.array_equal(matrix, identity) else points @ matrix[:3] + matrix[3]
            placed.append((thing.name, moved, faces))
            copied += len(points)
            if copied > most:
                raise ValueError("its build repeats objects too often")
    return placed
