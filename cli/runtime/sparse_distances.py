"""The sparse symmetric matrix of distances within a limit, whole or in shards.

The data of a shard are rows, columns and values of one of each two equal entries.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from geomhw_cli.runtime.job import Job
from geomhw_cli.specs.distance_methods import DistanceMethod
from geomhw_cli.specs.files import require_writable
from geomhw_cli.specs.masks import MaskSpec, MeshPart
from geomhw_cli.specs.shards import WHOLE, ShardPart

if TYPE_CHECKING:
    from geomhw.io.artifacts.shards import Shard

ENTRY = np.dtype([("row", "<i4"), ("column", "<i4"), ("value", "<f8")])
#: Entries that are sorted at a time.
_SORTED = 1 << 22


def compute_matrix(job: Job, method: DistanceMethod, mask: MaskSpec | None, shard: ShardPart = WHOLE) -> None:
    """Write the sparse matrix of distances between all vertices within a limit to the output of the job."""
    from geomhw import __version__
    from geomhw.geodesic.distance_matrix import symmetric_matrix
    from geomhw.io import write_matrix
    from geomhw.io.artifacts.shards import write_shard

    require_writable(job.outputs, shard.extensions([".npz"]))
    mesh = job.read()
    with job.stage("set up"):
        part = MeshPart.of(mesh, mask).mesh
        solver = method.front(part)
    n, limit = mesh.n_vertices, method.settings["limit"]
    with job.stage("compute"):
        found = solver.pairs(limit, slice(shard.number - 1, None, shard.of))
    stored = 2 * len(found[0]) - int((found[0] == found[1]).sum())
    statistics = {"largest_distance": float(found[2].max(initial=0.0)), "unreachable": 0}
    with job.stage("write"):
        if not shard.is_whole:
            run = {"version": __version__, "mesh": part.digest, "question": "--all-pairs", **method.report()}
            about = {"shape": [n, n], "stored": stored, **statistics}
            write_shard(job.outputs[0], run, shard.number, shard.of, "sparse", about, lambda: [_entries(*found)])
        else:
            write_matrix(job.outputs[0], symmetric_matrix(*found, n), compress=False)
    job.written.append(str(job.outputs[0]))
    report = {"question": "all-pairs", "queries": n, **shard.report(), "shape": [n, n], "stored": stored}
    lines = [f"sources: {n}", *shard.lines(), f"stored: {stored} distances within {limit:g}"]
    lines.append(f"largest: {statistics['largest_distance']:.10g}")
    job.finish(
        mesh, report | {"largest_distance": statistics["largest_distance"], **solver.settings(), "limit": limit}, lines
    )


def _entries(rows: Any, columns: Any, values: Any) -> bytes:
    """Return entries as the data of a shard."""
    found = np.empty(len(rows), dtype=ENTRY)
    found["row"], found["column"], found["value"] = rows, columns, values
    return found.tobytes()


def join_sparse(shards: "Sequence[Shard]", path: Path) -> None:
    """Write the symmetric matrix of all entries; the arrays stay in files until it is written."""
    from scipy.sparse import csr_array

    from geomhw.geodesic.distance_matrix import place_entries
    from geomhw.io import write_matrix

    n = shards[0].about["shape"][0]
    counts = np.zeros(n, dtype=np.int64)
    for block in _blocks(shards):
        counts += np.bincount(block["row"], minlength=n)
        counts += np.bincount(block["column"][block["row"] != block["column"]], minlength=n)
    starts = np.append(0, np.cumsum(counts))
    places = starts[:-1].copy()
    with TemporaryDirectory(dir=path.parent, prefix=".geomhw-") as folder:
        size = max(1, int(starts[-1]))
        indices = np.memmap(f"{folder}/indices", dtype=np.int32, mode="w+", shape=size)[: starts[-1]]
        data = np.memmap(f"{folder}/data", dtype=np.float64, mode="w+", shape=size)[: starts[-1]]
        for block in _blocks(shards):
            rows, columns, values = (np.ascontiguousarray(block[name]) for name in ("row", "column", "value"))
            place_entries(rows, columns, values, places, indices, data)
        first = 0
        while first < n:
            last = max(first + 1, int(np.searchsorted(starts, starts[first] + _SORTED, side="right")) - 1)
            span = slice(starts[first], starts[last])
            order = np.lexsort((indices[span], np.repeat(np.arange(last - first), counts[first:last])))
            indices[span], data[span] = indices[span][order], data[span][order]
            first = last
        write_matrix(path, csr_array((data, indices, starts), shape=(n, n)), compress=False)
        del indices, data


def _blocks(shards: "Sequence[Shard]") -> Iterator[Any]:
    """Arrays of entries."""
    for shard in shards:
        rest = b""
        for chunk in shard.chunks():
            rest += chunk
            whole = len(rest) // ENTRY.itemsize * ENTRY.itemsize
            yield np.frombuffer(rest[:whole], dtype=ENTRY)
            rest = rest[whole:]
