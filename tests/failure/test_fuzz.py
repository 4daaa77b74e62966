"""Damaged files: every reader raises one line or returns a result, within bounds on time and memory.

The long run, guided by coverage, is ``make fuzz``; its findings are kept in ``tests/fuzz/found``.
"""

import random
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fuzz.mutations import mutated
from fuzz.targets import TARGETS, feed
from geomhw.errors import FormatError
from geomhw.io import read, read_arrays, read_csv, read_series
from geomhw.io.formats.lz4_block import unpack_lz4
from geomhw.io.formats.meshio_read import FORMATS
from geomhw.mesh.ear_clipping import triangulate_polygons

FUZZ = Path(__file__).parents[1] / "fuzz"
SEEDS = {name: sorted((FUZZ / "corpus" / name).iterdir()) for name in TARGETS}
FOUND = sorted(path for path in (FUZZ / "found").iterdir())
DAMAGED_EACH = 110
SECONDS = 1.0
#: Bytes of memory per byte of a file, and for any file (imported modules, tables of a decoder).
MEMORY_A_BYTE, MEMORY, LZMA_MEMORY = 20, 1 << 20, 72 << 20


@pytest.fixture(scope="module", autouse=True)
def compiled_loops() -> None:
    """Compile the loops of the readers before times are taken."""
    triangulate_polygons(np.eye(3), np.arange(3), np.array([0]), np.array([3]))
    unpack_lz4(b"\x10a", 1)


@pytest.mark.parametrize("path", [path for paths in SEEDS.values() for path in paths], ids=lambda p: p.name)
def test_corpus_is_read(path: Path) -> None:
    """Every file of the corpus is read, or belongs to another mesh."""
    name = path.parent.name
    told = feed(name, path.read_bytes())
    assert told is None or "rows; the mesh has" in told


@pytest.mark.parametrize("name", TARGETS)
def test_damaged(name: str) -> None:
    """Files damaged at random, the same ones each time, take bounded time and memory."""
    seeds, chance = [path.read_bytes() for path in SEEDS[name]], random.Random(name)
    feed(name, seeds[0])
    for number in range(DAMAGED_EACH):
        data = mutated(seeds, chance)
        if f".{name}" in FORMATS:  # limited by themselves
            feed(name, data)
            continue
        allowed = MEMORY_A_BYTE * len(data) + (LZMA_MEMORY if b"LZMA" in data else MEMORY)
        before = time.process_time()
        peak = peak_memory(name, data)
        assert time.process_time() - before < SECONDS, number
        # The table of interned names of Python may grow by megabytes, but not twice.
        assert peak < allowed or peak_memory(name, data) < allowed, (number, len(data))


def peak_memory(name: str, data: bytes) -> int:
    """Return the peak memory of a reader in bytes."""
    tracemalloc.start()
    try:
        feed(name, data)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("path", FOUND, ids=lambda path: path.name)
def test_found(path: Path) -> None:
    """Each file that once broke a reader is refused within a second."""
    before = time.process_time()
    assert feed(path.name.split("-")[0], path.read_bytes())
    assert time.process_time() - before < SECONDS


def off(face: str) -> bytes:
    return b"OFF\n1000 50000 0\n" + b"0.1 0.2 0.3\n" * 1000 + f"{face}\n".encode() * 50000


def ply(form: str, body: bytes) -> bytes:
    lines = ["ply", f"format {form} 1.0", "element vertex 1000", *(f"property float {axis}" for axis in "xyz")]
    lines += ["element face 50000", "property list uchar int vertex_indices", "end_header", ""]
    return "\n".join(lines).encode() + body


def vtk(cells: str) -> bytes:
    head = "# vtk DataFile Version 3.0\n\nASCII\nDATASET POLYDATA\nPOINTS 1000 float\n" + "0.1 0.2 0.3\n" * 1000
    return (head + cells).encode()


TRIANGLE, QUAD = "3 100 200 300\n", "4 100 200 300 400\n"
BINARY = [np.array([3], "u1").tobytes() + np.array([1, 2, 3], "<i4").tobytes()]
BINARY += [np.array([4], "u1").tobytes() + np.array([1, 2, 3, 4], "<i4").tobytes()]
#: Large files: usual ones, and some that are overhead only.
LARGE: dict[str, tuple[str, bytes]] = {
    "triangles": (".off", off("3 100 200 300")),
    "quads": (".off", off("4 100 200 300 400")),
    "comments": (".off", b"#\n" * 200_000),
    "blank lines": (".obj", b"\n" * 400_000),
    "faces": (".obj", b"v 0.1 0.2 0.3\n" * 1000 + b"f 100 200 300\n" * 50000),
    "attributes": (".obj", b"v 0.1 0.2 0.3\n" * 1000 + b"f 10/1/1 20/2/2 30/3/3\n" * 50000),
    "words": (".obj", b"v\n" * 100_000),
    "text": (".ply", ply("ascii", b"0.1 0.2 0.3\n" * 1000 + TRIANGLE.encode() * 50000)),
    "mixed text": (".ply", ply("ascii", b"0.1 0.2 0.3\n" * 1000 + (TRIANGLE + QUAD).encode() * 25000)),
    "mixed binary": (".ply", ply("binary_little_endian", bytes(12000) + b"".join(BINARY) * 25000)),
    "no corners": (".ply", ply("binary_little_endian", bytes(12000 + 50000))),
    "solid": (".stl", b"solid x\n" + b"vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n" * 20000),
    "polygons": (".vtk", vtk("POLYGONS 50000 200000\n" + TRIANGLE * 50000)),
    "mixed polygons": (".vtk", vtk("POLYGONS 50000 225000\n" + (TRIANGLE + QUAD) * 25000)),
    "tags": (".vtp", b"<a/>" * 100_000),
    "tags with attributes": (".vtp", b"<VTKFile type='PolyData'>" + b"<a b=''/>" * 10_000 + b"</VTKFile>"),
    "one tag": (".vtp", b"<VTKFile " + b"".join(b"a%d='' " % i for i in range(100_000)) + b"/>"),
    "frames": (".pvd", b"<a>" + b'<DataSet timestep="0.1" part="0" file="a.00001.vtp"/>\n' * 20000 + b"</a>"),
    "numbers": (".csv", b"a,b\n" + b"10,2.5\n" * 50000),
    "texts": (".csv", b"a,b\n" + b"first,second\n" * 30000 + b"x" * 100_000 + b",\n"),
    "entries": (".mtx", b"%%MatrixMarket matrix coordinate real general\n900 900 50000\n" + b"10 20 0.5\n" * 50000),
}
READERS: dict[str, Callable[[Path], object]] = {".pvd": read_series, ".csv": read_csv, ".mtx": read_arrays}


@pytest.mark.parametrize("case", LARGE)
def test_memory_is_in_proportion(case: str, tmp_path: Path) -> None:
    """Reading takes at most 20 bytes per byte of the file."""
    extension, data = LARGE[case]
    path = tmp_path / f"large{extension}"
    path.write_bytes(data)
    reader = READERS.get(extension, read)
    tracemalloc.start()
    try:
        reader(path)
    except FormatError:
        pass
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peak < MEMORY_A_BYTE * len(data) + MEMORY


def test_a_wide_table_is_read_soon(tmp_path: Path) -> None:
    """A table of 50,000 columns is read in linear time."""
    path = tmp_path / "wide.csv"
    path.write_bytes(b",".join(b"column %d" % i for i in range(50_000)) + b"\n")
    before = time.process_time()
    assert len(read_csv(path)) == 50_000
    assert time.process_time() - before < 5 * SECONDS
