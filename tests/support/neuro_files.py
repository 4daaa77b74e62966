"""Files of GIFTI and FreeSurfer on a square of four vertices, as nibabel writes them or as bytes."""

from pathlib import Path
from typing import Any

import nibabel
import numpy as np
from nibabel.freesurfer import io as freesurfer
from nibabel.gifti import GiftiDataArray, GiftiImage, GiftiLabel, GiftiLabelTable, GiftiMetaData

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]])
FACES = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
NAMES = {0: "???", 1: "precentral", 3: "medial wall"}
LABELS = np.array([1, 3, 0, 3], np.int32)


def data_array(values: Any, intent: str, name: str = "", **settings: Any) -> GiftiDataArray:
    """An array of nibabel."""
    values = np.asarray(values)
    words = {"f": "FLOAT32", "i": "INT32", "u": "UINT8"}
    kind = f"NIFTI_TYPE_{words[values.dtype.kind]}"
    meta = GiftiMetaData({"Name": name} if name else {})
    return GiftiDataArray(values, intent=f"NIFTI_INTENT_{intent}", datatype=kind, meta=meta, **settings)


def surface(**settings: Any) -> GiftiImage:
    """The square."""
    arrays = [data_array(POINTS.astype("f4"), "POINTSET", **settings), data_array(FACES, "TRIANGLE", **settings)]
    return GiftiImage(darrays=arrays)


def labels() -> GiftiImage:
    """Labels of the vertices with their table."""
    table = GiftiLabelTable()
    for key, name in NAMES.items():
        label = GiftiLabel(key, 0.1, 0.2, 0.3, 1.0)
        label.label = name
        table.labels.append(label)
    return GiftiImage(darrays=[data_array(LABELS, "LABEL", "areas")], labeltable=table)


def metric(*arrays: Any) -> GiftiImage:
    """Arrays on the vertices, by the names ``map 0``, ..."""
    return GiftiImage(darrays=[data_array(values, "SHAPE", f"map {k}") for k, values in enumerate(arrays)])


def save_annot(path: Path) -> None:
    """Labels in FreeSurfer's format."""
    colors = np.array([[k * 40, 20, 200 - k, 0] for k in range(4)])
    names = [NAMES.get(k, f"other {k}") for k in range(4)]
    freesurfer.write_annot(path, LABELS, colors, names, fill_ctab=True)


def save_overlay(path: Path, values: np.ndarray) -> None:
    """An MGH or MGZ file of (frames, vertices)."""
    image = values.astype("f4").T[:, None, None, :]
    nibabel.save(nibabel.MGHImage(image if len(values) > 1 else image[..., 0], np.eye(4)), path)


def quads(mark: bytes = b"\xff\xff\xff") -> bytes:
    """The square as one quad, in FreeSurfer's older format."""
    counts = (4).to_bytes(3, "big") + (1).to_bytes(3, "big")
    points = (POINTS * 100).astype(">i2") if mark == b"\xff\xff\xff" else POINTS.astype(">f4")
    return mark + counts + points.tobytes() + b"".join(k.to_bytes(3, "big") for k in range(4))


LABEL_TEXT = b"#!ascii label  , from subject s vox2ras=TkReg\n2\n1  1.0 0.0 0.0 0.25\n3  0.0 1.0 0.5 -2.0\n"


def border_text(vertices: str = "0 1 2\n1 2 3", weights: str = "0.5 0.25 0.25\n0 1 1", closed: bool = False) -> str:
    """A border as Workbench writes it, on a surface of four vertices."""
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<BorderFile Version="3" Structure="CORTEX_LEFT" SurfaceNumberOfVertices="4">\n'
        "<MetaData><MD><Name>by</Name><Value>x</Value></MD></MetaData>\n"
        f'<Class Name="a" Red="0" Green="0" Blue="0"><Border Name="b" Red="1" Green="0" Blue="0"><BorderPart '
        f'Closed="{closed}"><Vertices>{vertices}</Vertices><Weights>{weights}</Weights></BorderPart></Border></Class>\n'
        "</BorderFile>\n"
    )
