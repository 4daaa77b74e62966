"""Results of a distributed mesh as files: VTK pieces with an index of them, or one file in the order of the input."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geomhw.arrays import Floats
from geomhw.distributed.heat_method import LocalResult
from geomhw.distributed.local_mesh import BLOCK, LocalMesh
from geomhw.io import npy_header, replacing, together
from geomhw.io.formats.vtk_write import TRIANGLE
from geomhw.io.writing import write
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.results import Field, Result

#: Extensions of an index of pieces, and of its pieces; extensions of gathered files.
INDEXES, GATHERED = {".pvtu": ".vtu", ".pvtp": ".vtp"}, (".vtu", ".vtp", ".npy")
#: Extensions that ``write_distributed`` knows.
WRITABLE = (*INDEXES, *GATHERED)
#: Arrays that viewers show first, by VTK's word for their kind.
FIRST_SHOWN = {"Scalars": "distance", "Vectors": "transported"}
_KINDS = {".vtu": ("UnstructuredGrid", "Cells"), ".vtp": ("PolyData", "Polys")}
_HEAD = '<VTKFile type="{}" version="1.0" byte_order="LittleEndian" header_type="UInt64">'


def write_distributed(result: LocalResult, paths: list[Path]) -> list[str]:
    """Write the arrays of a result to files, all or none; every rank calls it.

    Parameters
    ----------
    paths : ``.pvtu`` or ``.pvtp`` for an index and a piece of each rank that has faces, beside it. ``.vtu`` or ``.vtp``
        for one mesh in the order of the input, ``.npy`` for its distances; rank 0 writes them block by block.

    Returns
    -------
    Names of all files written.

    Raises
    ------
    FormatError
        If a file cannot be written on one of the ranks.
    """
    ranks, written = result.mesh.ranks, []
    with together():
        for path in paths:
            extension = path.suffix.lower()
            written += _write_pieces(result, path) if extension in INDEXES else _write_gathered(result, path)
        ranks.comm.Barrier()
    return written


def piece_path(path: Path, rank: int) -> Path:
    """The piece of a rank beside the index."""
    return path.with_name(f"{path.stem}_{rank}{INDEXES[path.suffix.lower()]}")


def _write_pieces(result: LocalResult, path: Path) -> list[str]:
    ranks = result.mesh.ranks
    with ranks.agreeing():
        piece = _piece(result)
        if piece:
            write(piece, piece_path(path, ranks.rank))
    sources = [piece_path(path, rank) for rank, has in enumerate(ranks.comm.allgather(piece is not None)) if has]
    with ranks.agreeing():
        if ranks.rank == 0:
            with replacing([path]) as (temporary,):
                temporary.write_text(_index(path, result, [source.name for source in sources]))
    return [str(path), *map(str, sources)]


def _piece(result: LocalResult) -> Result | None:
    """The faces of a rank, those whose lowest vertex is its own, with the arrays; None if it has no faces."""
    mesh = result.mesh
    extended = {name: mesh.with_ghosts(values) for name, values in _arrays(result).items()}
    lower = np.append(np.zeros(mesh.n_own, dtype=bool), mesh.ghosts < mesh.first)
    faces = mesh.faces[~lower[mesh.faces].any(axis=1)]
    if not len(faces):
        return None
    used = np.ones(len(mesh.vertices), dtype=bool)
    used[mesh.n_own :] = False
    used[faces.ravel()] = True
    places = np.cumsum(used, dtype=np.int32) - 1
    fields = [Field(name, "vertex", values[used]) for name, values in extended.items()]
    return Result(TriangleMesh(mesh.vertices[used], places[faces]), fields)


def _arrays(result: LocalResult) -> dict[str, NDArray[Any]]:
    """The fields, and the number of each vertex in the file."""
    return {**result.fields, "vertex": result.mesh.part.in_file}


def _index(path: Path, result: LocalResult, sources: list[str]) -> str:
    kind = f"P{_KINDS[INDEXES[path.suffix.lower()]][0]}"
    lines = ['<?xml version="1.0"?>', _HEAD.format(kind), f'<{kind} GhostLevel="0">', "<PPoints>"]
    lines += ['<PDataArray type="Float64" Name="Points" NumberOfComponents="3"/>', "</PPoints>"]
    first = next((f' {kind}="{name}"' for kind, name in FIRST_SHOWN.items() if name in result.fields), "")
    lines.append(f"<PPointData{first}>")
    for name, values in _arrays(result).items():
        width = f' NumberOfComponents="{values.shape[1]}"' if values.ndim > 1 else ""
        lines.append(f'<PDataArray type="{_type(values.dtype)}" Name="{name}"{width}/>')
    lines += ["</PPointData>", *(f'<Piece Source="{source}"/>' for source in sources), f"</{kind}>", "</VTKFile>", ""]
    return "\n".join(lines)


def _type(kind: np.dtype[Any]) -> str:
    return f"{'Float' if kind.kind == 'f' else 'UInt' if kind.kind == 'u' else 'Int'}{8 * kind.itemsize}"


def _write_gathered(result: LocalResult, path: Path) -> list[str]:
    mesh, extension = result.mesh, path.suffix.lower()
    in_order = {name: in_file_order(mesh, values) for name, values in result.fields.items()}
    if extension == ".npy":
        in_order = {"distance": in_order["distance"]}
    if mesh.ranks.rank:
        for values in in_order.values():
            for _ in _gathered(mesh, values):
                pass
        return [str(path)]
    head, blocks = _npy(mesh, in_order) if extension == ".npy" else _vtk(mesh, in_order, extension)
    with replacing([path]) as (temporary,), temporary.open("wb") as stream:
        stream.write(head)
        for block in blocks:
            stream.write(block)
    return [str(path)]


def _npy(mesh: LocalMesh, arrays: dict[str, Floats]) -> tuple[bytes, Iterator[bytes]]:
    values = arrays["distance"]
    return npy_header((mesh.n_vertices,), "<f8"), (block.astype("<f8").tobytes() for block in _gathered(mesh, values))


def _vtk(mesh: LocalMesh, arrays: dict[str, Floats], extension: str) -> tuple[bytes, Iterator[bytes]]:
    """The head of a VTK file with appended raw data, and its data block by block."""
    n, m = mesh.n_vertices, mesh.file.n_faces
    kind, cells = _KINDS[extension]
    sections = [("Points", [("Points", "Float64", 3, 8 * n)]), (cells, _cells(m, extension))]
    sections.append(("PointData", [(name, "Float64", *_width(values), 8 * n) for name, values in arrays.items()]))
    count = f'NumberOf{"Cells" if extension == ".vtu" else "Polys"}="{m}"'
    lines = ['<?xml version="1.0"?>', _HEAD.format(kind), f"<{kind}>", f'<Piece NumberOfPoints="{n}" {count}>']
    offset, sizes = 0, []
    for tag, members in sections:
        lines.append(f"<{tag}>")
        for name, type_name, width, size in members:
            wide = f' NumberOfComponents="{width}"' if width > 1 else ""
            lines.append(f'<DataArray type="{type_name}" Name="{name}"{wide} format="appended" offset="{offset}"/>')
            offset += 8 + size * width
            sizes.append(size * width)
        lines.append(f"</{tag}>")
    lines += ["</Piece>", f"</{kind}>", '<AppendedData encoding="raw">', "_"]
    return "\n".join(lines).encode(), _vtk_data(mesh, arrays, extension, sizes)


def _width(values: Floats) -> tuple[int]:
    return (values.shape[1] if values.ndim > 1 else 1,)


def _cells(m: int, extension: str) -> list[tuple[str, str, int, int]]:
    arrays = [("connectivity", "Int64", 1, 24 * m), ("offsets", "Int64", 1, 8 * m)]
    return arrays + ([("types", "UInt8", 1, m)] if extension == ".vtu" else [])


def _vtk_data(mesh: LocalMesh, arrays: dict[str, Floats], extension: str, sizes: list[int]) -> Iterator[bytes]:
    """Each array after its number of bytes, block by block."""
    file, lengths = mesh.file, iter(size.to_bytes(8, "little") for size in sizes)
    yield next(lengths)
    for begin in range(0, file.n_vertices, BLOCK):
        yield file.read_vertices(begin, min(begin + BLOCK, file.n_vertices)).astype("<f8").tobytes()
    yield next(lengths)
    for begin in range(0, file.n_faces, BLOCK):
        yield file.read_faces(begin, min(begin + BLOCK, file.n_faces)).astype("<i8").tobytes()
    yield next(lengths)
    for begin in range(0, file.n_faces, BLOCK):
        yield (3 * np.arange(begin + 1, min(begin + BLOCK, file.n_faces) + 1, dtype="<i8")).tobytes()
    if extension == ".vtu":
        yield next(lengths)
        for begin in range(0, file.n_faces, BLOCK):
            yield bytes([TRIANGLE]) * (min(begin + BLOCK, file.n_faces) - begin)
    for values in arrays.values():
        yield next(lengths)
        yield from (block.astype("<f8").tobytes() for block in _gathered(mesh, values))
    yield b"\n</AppendedData>\n</VTKFile>\n"


def in_file_order(mesh: LocalMesh, values: NDArray[Any]) -> NDArray[Any]:
    """Return the values of the vertices of the file that this rank has read, from those of its own vertices, (k,)."""
    order = np.argsort(mesh.part.in_file, kind="stable")
    counts = np.diff(np.searchsorted(mesh.part.in_file[order], mesh.part.file_starts))
    vertices, received = mesh.ranks.exchange(mesh.part.in_file[order], counts)
    found = mesh.ranks.send(values[order], counts, received)
    ordered = np.empty_like(found)
    ordered[vertices - mesh.part.file_starts[mesh.ranks.rank]] = found
    return ordered


def _gathered(mesh: LocalMesh, values: NDArray[Any]) -> Iterator[NDArray[Any]]:
    """Yield the values of all ranks on rank 0, block by block, in the order of the file; others send theirs."""
    ranks, sizes = mesh.ranks, np.diff(mesh.part.file_starts)
    for rank, size in enumerate(sizes):
        for begin in range(0, int(size), BLOCK):
            block = values[begin : begin + BLOCK] if rank == ranks.rank else None
            if rank and ranks.rank == rank:
                ranks.comm.send(block, dest=0)
            elif rank and ranks.rank == 0:
                block = ranks.comm.recv(source=rank)
            if block is not None and ranks.rank == 0:
                yield block
