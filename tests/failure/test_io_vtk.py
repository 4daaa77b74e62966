"""Damaged VTK files, and fields that VTK cannot hold, are refused with the reason."""

import re

import numpy as np
import pytest
import pyvista

from geomhw.errors import FieldError, FormatError
from geomhw.io import read, write
from geomhw.results import Field, Result
from support.vtk_files import BY_HAND, MESH, RESULT


def test_what_is_no_number_is_not_written(tmp_path):
    """Complex fields and duplicate names are refused, and no file is written."""
    with pytest.raises(FieldError, match=r"field 'z'.*complex128"):
        write(Result(MESH, [Field("z", "vertex", np.ones(4) * 1j)]), tmp_path / "moo.vtp")
    with pytest.raises(FieldError, match=r"two vertex fields.*'u'"):
        write(Result(MESH, [Field("u", "vertex", np.ones(4))] * 2), tmp_path / "moo.vtp")
    assert not list(tmp_path.iterdir())


LEGACY_WRONG = {
    "# vtk DataFile": ["does not start as"],
    BY_HAND.replace("POLYDATA", "STRUCTURED_POINTS"): ["STRUCTURED_POINTS"],
    BY_HAND.replace("0 0 1\nPOLY", "0 0 x\nPOLY"): ["line 5", "not a number"],
    BY_HAND.replace("1 2 3 4", "1 2 three 4"): ["line 15", "not a number"],
    BY_HAND[:-10]: ["line 24", "ends inside"],
    BY_HAND[:130]: ["ends inside"],
    BY_HAND.replace("NORMALS", "WEIRDNESS"): ["line 19", "'WEIRDNESS n"],
    BY_HAND.replace("n float", "n complex"): ["line 19", "'complex'"],
    BY_HAND.replace("POLYGONS 4", "POLYGONS four"): ["line 9", "not understood"],
    BY_HAND.replace("3 2 0 3", "9 2 0 3"): ["moo.vtk"],
    BY_HAND.replace("3 2 0 3", "3 2 0 9"): ["face 3", "vertex 9"],
    BY_HAND.replace("POLYGONS", "LINES"): ["no faces, only line"],
    BY_HAND.replace("CELL_DATA 4", "CELL_DATA 3"): ["'rgb' has 3 rows for 4 cells"],
}


@pytest.mark.parametrize("text", LEGACY_WRONG, ids=range(len(LEGACY_WRONG)))
def test_legacy_errors_are_named(tmp_path, text):
    """The message has the file, the line and the reason."""
    path = tmp_path / "moo.vtk"
    path.write_text(text)
    with pytest.raises(FormatError) as caught:
        read(path)
    for part in ["moo.vtk", *LEGACY_WRONG[text]]:
        assert part in str(caught.value)


XML_WRONG = {
    "not XML": (lambda text: "hello", "whole VTK XML file"),
    "cut": (lambda text: text[:-40], "whole VTK XML file"),
    "other kind": (lambda text: text.replace("PolyData", "ImageData"), "ImageData.*PolyData"),
    "compressor": (lambda text: text.replace("header_type", 'compressor="vtkLZ5DataCompressor" header_type'), "LZ5"),
    "no base64": (lambda text: text.replace('format="binary">', 'format="binary">A'), "whole VTK XML file"),
    "a point missing": (lambda text: re.sub(r".{32}</DataArray>", "</DataArray>", text, count=2), "ends early"),
    "bad type": (lambda text: text.replace('Int32" Name="conn', 'Text" Name="conn'), "whole VTK XML file"),
    "no piece": (lambda text: text.replace('Points="4"', 'Points="0"'), "no piece with points"),
    "no polys": (lambda text: text.replace("Polys>", "Polls>"), "no cells"),
}


@pytest.mark.parametrize("case", XML_WRONG)
def test_xml_errors_are_named(tmp_path, case):
    """The message has the file and the reason."""
    path = tmp_path / "moo.vtp"
    write(RESULT, path)
    change, part = XML_WRONG[case]
    before = path.read_text()
    after = change(before)
    assert after != before
    path.write_text(after)
    with pytest.raises(FormatError, match=part) as caught:
        read(path)
    assert "moo.vtp" in str(caught.value)


def test_a_grid_of_tetrahedra_is_refused(tmp_path):
    """A grid of tetrahedra is refused."""
    grid = pyvista.UnstructuredGrid({10: np.array([[0, 1, 2, 3]])}, MESH.vertices)
    grid.save(tmp_path / "moo.vtu")
    with pytest.raises(FormatError, match=r"moo\.vtu.*tetra.*triangles"):
        read(tmp_path / "moo.vtu")
