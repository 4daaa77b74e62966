"""Makes the corpus, small whole files in every dialect that a reader knows: ``cd tests && python -m fuzz.renew``."""

import gzip
import io
import re
import shutil
import sys
from pathlib import Path

import meshio
import numpy as np
import pyvista
import scipy.io
import scipy.sparse as sp
from nibabel.freesurfer import io as freesurfer
from PIL import Image
from vtkmodules.vtkIOGeometry import vtkSTLWriter
from vtkmodules.vtkIOLegacy import vtkPolyDataWriter, vtkUnstructuredGridWriter
from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

from geomhw.io import SeriesWriter, write, write_checkpoint, write_cloud
from geomhw.results import Cloud, Field
from support import neuro_files, obj_files, off_files, ply_files, scene_files, vtk_files

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


def dialects() -> None:
    """Forms of the formats that other programs write: binary, strips, pieces, concave polygons, STL of all kinds."""
    points = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [2, 1, 0], [0, 4, 0]], dtype=float)
    rows = ["{:g} {:g} {:g}".format(*point) for point in points.tolist()]
    floats, body = points.astype(">f4"), "\n".join(rows)
    off = _folder("off")
    words = [np.array([5, 1, 0], ">i4").tobytes(), np.array([5, 0, 1, 2, 3, 4, 0], ">i4").tobytes()]
    (off / "binary.off").write_bytes(b"OFF BINARY\n" + words[0] + floats.tobytes() + words[1])
    colored = "\n".join(f"{row} 0 0 1 255 0 0 255" for row in rows)
    (off / "NCOFF.off").write_text(f"NCOFF\n5 1 0\n{colored}\n5 0 1 2 3 4\n")
    (off / "nOFF.off").write_text(f"nOFF # of\n3\n5 1 0\n{body}\n5 0 1 2 3 4\n")
    (off / "tokens.off").write_text(f"OFF 5 2 0 {' '.join(rows)}\n3 0 1\n3\n4 0 3 3 4\n")
    (off / "short_faces.off").write_text(f"OFF\n5 4 0\n{body}\n3 0 1 3\n2 0 1\n4 0 3 3 4\n0\n\n9 9\n")
    vertices = "".join(f"v {row}\n" for row in rows)
    (_folder("obj") / "concave.obj").write_text(f"{vertices}usemtl a\\\nf 1 2 3 \\\n4 5\nf 1 1 2\nl 1 2\nf 1 2\n\0\0")
    (_folder("obj") / "flat.obj").write_text("v 0 0\nv 1 0\nv 1 1\nv nan 0\nf 1 2 3\n")
    head = "ply\nformat {} 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
    faces = "element face 1\nproperty list uchar int vertex_indices\nproperty uchar label\n"
    strips = "element tristrips 1\nproperty list int int vertex_indices\n"
    integers = np.array([6, 0, 1, 3, -1, 4, 0], ">i4").tobytes()
    for name, parts in {"strips": strips, "strips_faces": faces + strips}.items():
        text = body + ("\n5 0 1 2 3 4 7" if faces in parts else "") + "\n6 0 1 3 -1 4 0\n8 8\n"
        (_folder("ply") / f"{name}.ply").write_text(head.format("ascii") + parts + "end_header\n" + text)
        polygon = b"\5" + np.arange(5, dtype=">i4").tobytes() + b"\7" if faces in parts else b""
        header = (head.format("binary_big_endian") + parts + "end_header\n").encode()
        (_folder("ply") / f"{name}_binary.ply").write_bytes(header + floats.tobytes() + polygon + integers + b"\n\n")
    legacy = f"# vtk DataFile Version 3.0\nt\nascii\nDATASET {{}}\nPOINTS 5 float\n{body}\n"
    texts_after = "CELL_DATA 2\nFIELD f 2\nname 1 2 string\na%20b\nc\nbits 1 2 bit\n1 0\n"
    polydata = legacy.format("polydata") + "polygons 1 6 5 0 1 2 3 4\nTRIANGLE_STRIPS 1 5\n4 0 1 2 3\n"
    (_folder("vtk") / "strips.vtk").write_text(polydata + texts_after)
    grid = legacy.format("UNSTRUCTURED_GRID") + "CELLS 3 14\n4 0 1 2 3\n4 0 1 2 3\n3 0 1 2\nCELL_TYPES 3\n10 6 5\n"
    (_folder("vtk") / "volume.vtk").write_text(grid)
    curved = "CELLS 2 16\n6 0 1 2 3 4 0\n8 0 1 2 3 4 0 1 2\nCELL_TYPES 2\n22 23\n"
    (_folder("vtk") / "second_order.vtk").write_text(legacy.format("UNSTRUCTURED_GRID") + curved)
    heights = "POINT_DATA 6\nSCALARS a float\nLOOKUP_TABLE default\n1 2 3 4 5 6\n"
    head = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET {}\nDIMENSIONS {}\n"
    image = head.format("STRUCTURED_POINTS", "3 1 2") + "ORIGIN 0 0 1\nSPACING 1 1 2\n"
    (_folder("vtk") / "image.vtk").write_text(image + heights)
    axes = "X_COORDINATES 2 float\n0 1\nY_COORDINATES 3 float\n0 1 3\nZ_COORDINATES 1 int\n4\n"
    (_folder("vtk") / "axes.vtk").write_text(head.format("RECTILINEAR_GRID", "2 3 1") + axes + heights)
    stl = _folder("stl")
    facet = "facet normal 0 0 1\nouter loop\nvertex {}\nvertex {}\nvertex {}\nendloop\nendfacet\n"
    solid = (
        facet.format(*rows[:3]) + facet.format(rows[0], "2 1.0000001 0", rows[4]) + facet.format(rows[0], *rows[2:4])
    )
    (stl / "upper.stl").write_text(f"\ufeff\n SOLID a\n{solid.upper()}ENDSOLID\n", encoding="utf-8")
    (stl / "one_line.stl").write_text("solid " + solid.replace("\n", " ") + "endsolid")
    (stl / "solids.stl").write_text(f"solid a\n{solid}endsolid a\nsolid b\n{solid}endsolid b\n")
    binary = np.zeros(2, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]))
    binary["corners"] = points[[[0, 1, 2], [0, 2, 3]]]
    (stl / "solid_binary.stl").write_bytes(b"solid".ljust(80) + b"\2\0\0\0" + binary.tobytes() + b"surplus")
    for extension, writer_type in (("vtp", vtkXMLPolyDataWriter), ("vtu", vtkXMLUnstructuredGridWriter)):
        for mode in ("Ascii", "Binary", "Appended"):
            surface = pyvista.Plane(i_resolution=3, j_resolution=2)
            data = surface if extension == "vtp" else surface.cast_to_unstructured_grid()
            writer = writer_type()
            writer.SetInputData(data)
            writer.SetFileName(str(_folder(extension) / f"{mode}_LZ4.{extension}"))
            writer.SetCompressorTypeToLZ4()
            getattr(writer, f"SetDataModeTo{mode}")()
            writer.Write()
    for extension in ("vtp", "vtu"):
        path = _folder(extension) / f"Ascii_None.{extension}"
        (piece,) = re.findall(rb"<Piece.*</Piece>", path.read_bytes(), re.DOTALL)
        path.with_name(f"pieces.{extension}").write_bytes(path.read_bytes().replace(piece, piece + b"\n" + piece))


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


def scenes() -> None:
    """Scenes of glTF and 3MF: of trimesh, and made by hand with transforms, strips and parts."""
    for kind in ("glb", "3mf"):
        (_folder(kind) / f"trimesh.{kind}").write_bytes(scene_files.of_trimesh(kind))
    for name, mode in (("triangles", 4), ("strip", 5), ("fan", 6)):
        (_folder("gltf") / f"{name}.gltf").write_bytes(scene_files.gltf(mode))
    (_folder("3mf") / "parts.3mf").write_bytes(scene_files.threemf())
    item = '<item objectid="1" p:path="/b.model"/><item objectid="2" p:path="b.model"/>'
    parts = '<object id="2"><components><component objectid="1"/></components></object>'
    files = {
        "_rels/.rels": f'<Relationship Target="/a.xml" Type="{scene_files.MAIN}"/>',
        "a.xml": scene_files.model("", item),
        "b.model": scene_files.model(scene_files.square_object() + parts),
    }
    (_folder("3mf") / "files.3mf").write_bytes(scene_files.archive(files))


def neuro() -> None:
    """Files of GIFTI and FreeSurfer in every encoding, as nibabel writes them."""
    values = np.array([0.25, 1, -2, 8], "f4")
    for encoding in ("ASCII", "B64BIN", "B64GZ"):
        image = neuro_files.surface(encoding=f"GIFTI_ENCODING_{encoding}")
        image.to_filename(_folder("gii") / f"{encoding}.gii")
    (_folder("gii") / "gzip.gii").write_bytes(gzip.compress((_folder("gii") / "ASCII.gii").read_bytes(), mtime=0))
    write(vtk_files.RESULT, _folder("gii") / "ours.gii")
    neuro_files.metric(values, 2 * values).to_filename(_folder("func") / "metric.func.gii")
    neuro_files.labels().to_filename(_folder("func") / "labels.label.gii")
    geometry = _folder("freesurfer")
    info = {"head": [20], "valid": "1", "filename": "a", "volume": [9, 9, 9], "voxelsize": [1.0, 1.0, 1.0]}
    info |= {f"{name}ras": np.arange(3.0) for name in "xyzc"}
    points = neuro_files.POINTS
    freesurfer.write_geometry(geometry / "triangles", points, neuro_files.FACES, "created by x", info)
    (geometry / "quads").write_bytes(neuro_files.quads())
    (geometry / "new_quads").write_bytes(neuro_files.quads(b"\xff\xff\xfd"))
    freesurfer.write_morph_data(_folder("curv") / "lh.thickness", values, fnum=2)
    (_folder("curv") / "old").write_bytes(b"\0\0\4\0\0\2" + (values * 100).astype(">i2").tobytes())
    neuro_files.save_annot(_folder("annot") / "lh.annot")
    for closed in (False, True):
        text = neuro_files.border_text("0 1 2\n1 2 3\n2 3 0", "0.5 0.25 0.25\n0 1 1\n1 0 0", closed)
        (_folder("border") / f"closed_{closed}.border").write_text(text)
    (_folder("label") / "lh.label").write_bytes(neuro_files.LABEL_TEXT)
    for kind in ("mgh", "mgz"):
        neuro_files.save_overlay(_folder(kind) / f"a.{kind}", np.stack([values, 2 * values]))


if __name__ == "__main__":
    shutil.rmtree(CORPUS, ignore_errors=True)
    for part in (texts, ours, of_vtk, dialects, of_meshio, others, neuro, scenes):
        part()
