"""Files of distances for many queries: of a whole run, a shard of it, or joined from all shards."""

import csv
import heapq
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import StringIO
from math import inf
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from geomhw.arrays import Floats, Ints
    from geomhw.io.artifacts.shards import Shard

_READ = 1 << 22
#: Extensions of the file that each kind of shard joins to.
EXTENSIONS = {"rows": [".npy"], "pairs": [".csv", ".npy"], "labels": [".csv"], "sparse": [".npz"]}


def join(shards: "Sequence[Shard]", path: Path) -> dict[str, Any]:
    """Write the file of one run from all of its shards; return what the report says of the distances."""
    about = shards[0].about
    statistics = joined_statistics([shard.about for shard in shards])
    if shards[0].kind == "pairs":
        write_pairs(path, heapq.merge(*(shard.lines() for shard in shards), key=_line_number), about["dtype"])
    elif shards[0].kind == "sparse":
        from geomhw_cli.runtime.sparse_distances import join_sparse

        join_sparse(shards, path)
        statistics |= {"stored": sum(shard.about["stored"] for shard in shards)}
    elif shards[0].kind == "labels":
        with TemporaryFile(dir=path.parent) as stream:
            for shard in shards:
                for data in shard.chunks():
                    stream.write(data)
            statistics |= write_labels(path, _mapped(stream, about), about)
    else:
        from geomhw.io.artifacts.arrays import npy_header
        from geomhw.io.artifacts.shards import join_shards

        join_shards(shards, path, npy_header(tuple(about["shape"]), about["dtype"]))
    return {"shape": about["shape"], **statistics}


def file_chunks(path: Path, start: int) -> Iterator[bytes]:
    """Read a file from a byte on, piece by piece."""
    with path.open("rb") as stream:
        stream.seek(start)
        while data := stream.read(_READ):
            yield data


def pair_lines(words: Sequence[Sequence[str]], numbers: "Ints", distances: "Floats") -> Iterator[bytes]:
    """Lines of a table in order, each after its number and a tab. numbers: of the lines of the distances."""
    import numpy as np

    for k in np.argsort(numbers, kind="stable").tolist():
        line = StringIO()
        csv.writer(line, lineterminator="\n").writerow([*words[numbers[k]], repr(float(distances[k]))])
        yield f"{numbers[k]}\t{line.getvalue()}".encode()


def write_pairs(path: Path, lines: Iterable[bytes], dtype: str) -> None:
    """Write the distances of pairs in the order of their lines, as a table or an array."""
    import numpy as np

    from geomhw.io import replacing
    from geomhw.io.artifacts.arrays import npy_header

    rows = (line.rstrip(b"\n").partition(b"\t")[2] for line in lines)
    with replacing([path]) as (temporary,):
        if path.suffix.lower() == ".npy":
            distances = np.fromiter((float(row.rpartition(b",")[2]) for row in rows), dtype=float).astype(dtype)
            temporary.write_bytes(npy_header(distances.shape, dtype) + distances.tobytes())
            return
        with temporary.open("wb") as stream:
            stream.write(b"source,target,distance\n")
            stream.writelines(row + b"\n" for row in rows)


def write_labels(path: Path, values: "Floats", about: Mapping[str, Any]) -> dict[str, Any]:
    """Write the statistics between labels, one row per pair; return what the report says of them.

    values: statistics of all sources, (n, s, L). about: ``groups``, ``labels``, ``statistics`` and ``beyond``.
    """
    import numpy as np

    from geomhw.geodesic.label_groups import label_table
    from geomhw.io import write_csv

    table = label_table(values, [np.array(group) for group in about["groups"]], about["statistics"])
    found = statistics_of(table)
    table[table == inf] = float(about["beyond"])
    labels = [int(value) if value.is_integer() else value for value in about["labels"]]
    rows = [
        {"source": source, "target": target, **dict(zip(about["statistics"], numbers, strict=True))}
        for k, source in enumerate(labels)
        for target, numbers in zip(labels, table[:, k].T.tolist(), strict=True)
    ]
    write_csv(path, rows)
    return found


def statistics_of(values: "Floats") -> dict[str, Any]:
    """The largest finite distance and the number of infinite ones."""
    import numpy as np

    finite = np.isfinite(values)
    return {
        "largest_distance": float(values.max(where=finite, initial=0.0)),
        "unreachable": int(values.size - np.count_nonzero(finite)),
    }


def joined_statistics(parts: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The statistics of all parts."""
    return {
        "largest_distance": max((part["largest_distance"] for part in parts), default=0.0),
        "unreachable": sum(part["unreachable"] for part in parts),
    }


def _line_number(line: bytes) -> int:
    return int(line.partition(b"\t")[0])


def _mapped(stream: Any, about: Mapping[str, Any]) -> "Floats":
    """The numbers in a file as an array that stays there."""
    import numpy as np

    stream.flush()
    return np.memmap(stream, dtype=about["dtype"], mode="r", shape=tuple(about["shape"]))
