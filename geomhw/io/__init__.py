"""Meshes and fields from files, and results into them.

``read`` and ``read_field`` take data in, ``write`` and ``write_png`` put it out, whole or not at all; ``check_outputs``
says beforehand whether that can work. ``replacing`` makes any other file appear whole or not at all.
"""

from geomhw.io.artifacts.image import write_png
from geomhw.io.atomic import replacing
from geomhw.io.fields import field_file, read_field
from geomhw.io.reading import READABLE, read, read_cloud, read_mesh
from geomhw.io.writing import WRITABLE, check_outputs, write, write_cloud

__all__ = [
    "READABLE",
    "WRITABLE",
    "check_outputs",
    "field_file",
    "read",
    "read_cloud",
    "read_field",
    "read_mesh",
    "replacing",
    "write",
    "write_cloud",
    "write_png",
]
