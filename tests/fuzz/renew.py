"""Makes the corpus, small whole files in every dialect that a reader knows: ``cd tests && python -m fuzz.renew``."""

import io
import re
import shutil
import sys
from pathlib import Path

import meshio
import numpy as np
import scipy.io
import scipy.sparse as sp
from PIL import Image
from vtkmodules.vtkIOGeometry import vtkSTLWriter
from vtkmodules.vtkIOLegacy import vtkPolyDataWriter, vtkUnstructuredGridWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

from geomhw.io import SeriesWriter, write, write_checkpoint, write_cloud
from geomhw.results import Cloud, Field
from support import obj_files, off_files, ply_files, vtk_files

CORPUS = Path(__file__).resolve().parent / "corpus"
SU2 = """NDIME= 3
NELEM= 2
5 0 1 2 0
9 0 1 2 3 1
NPOIN= 4
0 0 0 0
1 0 0 1
1 1 0 2
0 1 0.5 3
NMARK= 1
MARKER_TAG= side
MARKER_ELEMS= 1
3 0 1
"""


def _folder(target: str) -> Path:
    folder = CORPUS / target
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def texts() -> None:
    """The dialects of OFF, OBJ and PLY that the tests of their readers know."""
    for target, dialects in (("off", off_files.SAME), ("obj", obj_files.SAME)):
        for dialect, text in dialects.items():
            (_folder(target) / f"{dialect.replace(' ', '_')}.{target}").write_bytes(text.encode())
    for form, body in ply_files.BODIES.items():
        (_folder("ply") / f"{form}.ply").write_bytes(ply_files.HEADER.format(form=form).encode() + body)


def ours() -> None:
    """What this project's writers write."""
    for extension in ("vtk", "vtp", "vtu", "ply"):
        write(vtk_files.RESULT, _folder(extension) / f"ours.{extension}")
    cloud = Cloud(np.eye(3), [Field("id", "vertex", np.arange(3)), Field("past_times", "mesh", np.array([0.1, 0.2]))])
    write_cloud(cloud, _folder("cloud") / "points.vtp")
    write_checkpoint(_folder("state") / "state.npz", {"step": 3, "run": {"dt": 0.1}}, {"color": np.arange(4.0)})
    made = _folder("series") / "made"
    made.mkdir()
    writer = SeriesWriter(made / "run.pvd")
    for k in range(2):
        writer.add(k / 10, vtk_files.RESULT, cloud)
    shutil.copy(made / "run.pvd", made.parent)
    shutil.rmtree(made)


def of_vtk() -> None:
    """What VTK writes: legacy and XML, text and binary, inline and appended, compressed or not, and STL."""
    for extension, writer_type in (("vtp", vtkXMLPolyDataWriter), ("vtu", vtkXMLUnstructuredGridWriter)):
        for mode, compressor in (
            ("Ascii", "None"),
            ("Binary", "ZLib"),
            ("Appended", "None"),
            ("AppendedRaw", "LZMA"),
            ("AppendedRaw", "None"),
            ("Appended", "ZLib"),
        ):
            writer = writer_type()
            writer.SetInputData(vtk_files.as_vtk(extension))
            writer.SetFileName(str(_folder(extension) / f"{mode}_{compressor}.{extension}"))
            getattr(writer, f"SetDataModeTo{mode.removesuffix('Raw')}")()
            writer.SetEncodeAppendedData(not mode.endswith("Raw"))
            getattr(writer, f"SetCompressorTypeTo{compressor}")()
            writer.Write()
    for kind, writer_type in (("vtp", vtkPolyDataWriter), ("vtu", vtkUnstructuredGridWriter)):
        for version in (42, 51):
            for mode in ("ASCII", "Binary"):
                writer = writer_type()
                writer.SetInputData(vtk_files.as_vtk(kind))
                writer.SetFileName(str(_folder("vtk") / f"{kind}_{version}_{mode}.vtk"))
                writer.SetFileVersion(version)
                getattr(writer, f"SetFileTypeTo{mode}")()
                writer.Write()
    for mode in ("ASCII", "Binary"):
        writer = vtkSTLWriter()
        writer.SetInputData(vtk_files.as_vtk("vtp"))
        writer.SetFileName(str(_folder("stl") / f"{mode}.stl"))
        getattr(writer, f"SetFileTypeTo{mode}")()
        writer.Write()


def of_meshio() -> None:
    """What meshio writes in the formats that it reads for us."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]])
    mesh = meshio.Mesh(points, [("triangle", [[0, 1, 2]]), ("quad", [[0, 1, 2, 3]])])
    mixed = meshio.Mesh(points, [("triangle", [[0, 1, 2], [0, 2, 3]]), ("line", [[0, 1]]), ("tetra", [[0, 1, 2, 3]])])
    plain = meshio.Mesh(points, [("triangle", [[0, 1, 2], [0, 2, 3]])], point_data={"u": np.arange(4.0)})
    for name, kinds in {
        "msh": ("gmsh", "gmsh22"),
        "mesh": ("medit",),
        "meshb": ("medit",),
        "inp": ("abaqus",),
        "bdf": ("nastran",),
        "vol": ("netgen",),
    }.items():
        for kind in kinds:
            for label, content in (("quad", mesh), ("mixed", mixed), ("plain", plain)):
                for binary in (False, True) if name == "msh" else (None,):
                    path = _folder(name) / f"{kind}_{label}{'_binary' if binary else ''}.{name}"
                    options = {} if binary is None else {"binary": binary}
                    try:
                        content.write(path, file_format=kind, **options)
                        path.write_bytes(re.sub(rb"np\.float64\((.*?)\)", rb"\1", path.read_bytes()))  # its slip
                    except Exception as error:  # not every format takes every cell
                        print(f"{path.name}: {error}", file=sys.stderr)
                        path.unlink(missing_ok=True)
    (_folder("su2") / "square.su2").write_text(SU2)
    shutil.copytree(CORPUS / "bdf", CORPUS / "nas", dirs_exist_ok=True)
    for path in (CORPUS / "nas").iterdir():
        path.rename(path.with_suffix(".nas"))


def others() -> None:
    """Tables, documents, arrays, matrices and pictures."""
    (_folder("table") / "plain.csv").write_text("step,time,name\n0,0.0,a\n1,1e-3,b\n")
    (_folder("table") / "quoted.csv").write_text('"a ""b""",c\r\n"1\n2",\r\n')
    (_folder("columns") / "vectors.csv").write_text("x,y,z\n" + "".join(f"{k},{k / 3},-{k}e-2\n" for k in range(4)))
    (_folder("document") / "report.json").write_text('{"a": [1, 2.5, NaN, null], "b": {"c": "\\u00e9", "d": true}}\n')
    u = np.arange(4.0)
    for name, array in {"u": u, "v": np.ones((2, 3), ">f4", order="F"), "i": np.arange(4, dtype=np.int8)}.items():
        for target in ("array", "npy"):
            np.save(_folder(target) / f"{name}.npy", array)
    matrix = sp.random_array((5, 4), density=0.4, format="csr", rng=np.random.default_rng(0))
    for target in ("archive", "npz"):
        np.savez(_folder(target) / "two.npz", u=u, v=np.ones((2, 3)))
        np.savez_compressed(_folder(target) / "packed.npz", u=np.zeros(4), v=u)
    sp.save_npz(_folder("npz") / "matrix.npz", matrix)
    for field, symmetry in (("real", "general"), ("complex", "general"), ("pattern", "symmetric")):
        stream = io.BytesIO()
        square = matrix @ matrix.T
        scipy.io.mmwrite(
            stream, square.astype(complex) if field == "complex" else square, field=field, symmetry=symmetry
        )
        (_folder("mtx") / f"{field}.mtx").write_bytes(stream.getvalue())
    pixels = np.random.default_rng(0).integers(0, 256, (6, 5, 4), dtype=np.uint8)
    for mode in ("RGB", "RGBA", "L", "P", "1", "LA"):
        Image.fromarray(pixels).convert(mode).save(_folder("picture") / f"{mode}.png")


if __name__ == "__main__":
    shutil.rmtree(CORPUS, ignore_errors=True)
    for part in (texts, ours, of_vtk, of_meshio, others):
        part()
