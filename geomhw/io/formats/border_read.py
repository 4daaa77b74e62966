"""Reader of borders of Connectome Workbench: polylines whose points lie between three vertices of a surface."""

from xml.etree.ElementTree import Element, ParseError

import numpy as np

from geomhw.arrays import Floats, Ints
from geomhw.errors import FormatError
from geomhw.io.formats.number_parsing import parse_array
from geomhw.io.formats.xml_tree import parse_xml
from geomhw.results import Cloud

#: The version of the format that Workbench writes since 2014.
_VERSION = "3"


def read_border(name: str, data: bytes, vertices: Floats) -> Cloud:
    """Return the parts of all borders as polylines; closed ones end where they start.

    vertices : (n, 3), of the surface on which the borders are.
    """
    try:
        root = parse_xml(data)
        if root.tag != "BorderFile":
            raise FormatError(f"{name} is no border file: its first element is {root.tag[:40]}")
        if (version := root.get("Version")) != _VERSION:
            raise FormatError(
                f"{name} is of version {str(version)[:20]} of the format; write it anew with wb_command -border-merge"
            )
        if (count := int(root.get("SurfaceNumberOfVertices", "-1"))) != len(vertices):
            raise FormatError(f"{name} is of a surface of {count} vertices, and the mesh has {len(vertices)}")
        parts = [_points(part, vertices) for part in root.iter("BorderPart")]
    except (ParseError, ValueError) as error:
        raise FormatError(f"{name} is damaged: {error}") from None
    if not parts:
        raise FormatError(f"{name} holds no border")
    return Cloud(np.concatenate(parts), (), np.append(0, np.cumsum([len(part) for part in parts])))


def _points(part: Element, vertices: Floats) -> Floats:
    """Positions of the points of a part, (k, 3); ValueError for a damaged one."""
    corners = np.asarray(_rows(part, "Vertices", np.dtype(np.int64)))
    weights = np.asarray(_rows(part, "Weights", np.dtype(np.float64)))
    if len(corners) != len(weights) or not len(corners):
        raise ValueError(f"a part has {len(corners)} points and {len(weights)} weights")
    if corners.min() < 0 or corners.max() >= len(vertices):
        raise ValueError(f"a point lies at vertex {corners.max() if corners.min() >= 0 else corners.min()}")
    total = weights.sum(axis=1, keepdims=True)
    if not (np.isfinite(weights).all() and (weights >= 0).all() and (total > 0).all()):
        raise ValueError("the weights of a point are negative, not finite or all zero")
    points = np.einsum("kc,kcx->kx", weights / total, vertices[corners])
    return np.concatenate([points, points[:1]]) if part.get("Closed") == "True" and len(points) > 1 else points


def _rows(part: Element, name: str, kind: np.dtype[np.int64] | np.dtype[np.float64]) -> Floats | Ints:
    """Three numbers for each point of a part."""
    values = parse_array((part.findtext(name) or "").encode(), kind)
    if len(values) % 3:
        raise ValueError(f"{name} of a part has {len(values)} numbers, not three for each point")
    return values.reshape(-1, 3)
