"""``geomhw geodesic``: geodesic distance by the heat method, or exact."""

from math import inf
from pathlib import Path
from typing import Any

import click

from geomhw.options import HEAT_METHOD, Boundary, DistanceMethodName, EngineName, GeodesicPanel, TableStatistic
from geomhw_cli import options
from geomhw_cli.options import INPUT, Choice, Choices, OptionGroup, choice, command, flag, option
from geomhw_cli.output_options import VECTOR_FILES
from geomhw_cli.runtime.dask_cluster import SCHEDULER
from geomhw_cli.runtime.distance_batch import compute_distances
from geomhw_cli.runtime.distance_runs import front_distances, heat_distances
from geomhw_cli.runtime.job import Job
from geomhw_cli.runtime.picture_kinds import KINDS
from geomhw_cli.specs.distance_methods import DistanceMethod
from geomhw_cli.specs.files import Spec
from geomhw_cli.specs.label_tables import LabelTable
from geomhw_cli.specs.masks import MaskSpec
from geomhw_cli.specs.numbers import LARGEST, SMALLEST, Number
from geomhw_cli.specs.queries import DistanceQueries
from geomhw_cli.specs.shards import WHOLE, ShardPart, shard_option
from geomhw_cli.specs.sources import SourceSpecs


@command(
    OptionGroup(
        "Input",
        options.SOURCE,
        flag("--all-pairs", "Distances between all vertices: a matrix, -o D.npy; with --labels a table, -o D.csv."),
        option(
            "--labels",
            "FILE:ARRAY",
            Spec(lambda text: [LabelTable(text).path]),
            "With --all-pairs: a row of statistics for each pair of labels of this array, per vertex or per face.",
        ),
        option(
            "--table",
            "NAMES",
            Choices(TableStatistic),
            "Statistics of these rows: mean, min and max of the distances from the vertices of one label to those of "
            "another, separated by commas.  [default: mean,min,max]",
        ),
        option("--pairs", "FILE", INPUT, "Distances from a source to a vertex, one pair per line: -o D.csv or D.npy."),
        option(
            "--sources source_file",
            "FILE",
            INPUT,
            "Distances to all vertices from one set of sources per line: -o D.npy.",
        ),
    ),
    OptionGroup(
        "Method",
        choice(
            "--method method_name",
            DistanceMethodName,
            "heat: the heat method. exact: the shortest paths on the triangles, exact up to rounding, on any mesh. "
            "fast-marching: these within 0.2 % on average, in less time than any other method.",
        ),
        option(
            "--limit",
            "R",
            Number(SMALLEST, LARGEST, or_zero=True),
            "Largest distance; larger ones are inf and take no time. For --method exact and fast-marching.",
        ),
        option(
            "--mask",
            "FILE:ARRAY",
            Spec(lambda text: [MaskSpec(text).path]),
            "Paths stay in the part of MESH where this array is not zero, per vertex or per face; also @FILE, a text "
            "file of the vertices. All other distances are inf.",
            callback=lambda _context, _option, text: MaskSpec.parse(text),
        ),
        option(
            "--to",
            "SPEC",
            str,
            "Vertices whose distances are wanted, written as in --source: the columns of a matrix, in this order. With "
            "--method exact and fast-marching, larger distances than theirs take no time; without a matrix they are "
            "inf.",
            multiple=True,
            callback=lambda _context, _option, texts: SourceSpecs.parse(texts),
        ),
    ),
    OptionGroup(
        "Method",
        option(
            "--time",
            "T",
            str,
            f"Diffusion time: {options.TIME_HELP}. h is the mean edge length; auto is sqrt-h if that is near h2 and "
            "more accurate on MESH, else h2.",
            default="auto",
        ),
        options.ROBUST,
        click.Option(
            ["--refine/--no-refine"],
            default=None,
            help="Replace the distances by exact ones; the other arrays stay those of heat.  [default: with --robust]",
        ),
        click.Option(
            ["--bound/--no-bound"],
            default=True,
            help="Clamp distances by heat to the shortest path along edges and, where they are not positive, to the "
            "straight line.  [default: --bound]",
        ),
        choice(
            "--boundary",
            Boundary,
            "Boundary condition of the heat flow: no flux, zero heat, or the mean of both solutions, which is the most "
            "accurate near the boundary.",
        ),
        options.SOLVER,
        name="method",
    ),
    OptionGroup("Method", options.ENGINE),
    VECTOR_FILES,
    OptionGroup(
        "Output",
        click.Option(
            ["--panel", "panels"],
            type=Choice(GeodesicPanel),
            multiple=True,
            default=HEAT_METHOD,
            help="Panel of the picture. May be repeated.",
        ),
        option("--beyond", "VALUE", Number(-inf, inf), "Written in place of infinite distances.", default=inf),
        flag("--single", "Single precision, with --all-pairs, --pairs or --sources."),
        shard_option("sources of --all-pairs, --pairs or --sources", "such as -o D.K.shard"),
        SCHEDULER,
        flag(
            "--estimate",
            "Print the processor time and memory that the run would take, from the first bytes of MESH, and compute "
            "nothing.",
        ),
    ),
    options.REPORT,
)
def geodesic(
    mesh_path: Path,
    sources: SourceSpecs,
    all_pairs: bool,
    labels: str | None,
    table: tuple[TableStatistic, ...] | None,
    pairs: Path | None,
    source_file: Path | None,
    method_name: DistanceMethodName,
    limit: float | None,
    mask: MaskSpec | None,
    to: SourceSpecs,
    method: dict[str, Any],
    engine: EngineName,
    files: dict[str, Any],
    panels: tuple[str, ...],
    beyond: float,
    single: bool,
    shard: ShardPart | None,
    scheduler: str | None,
    estimate: bool,
    report: dict[str, Any],
) -> None:
    """Compute geodesic distance on MESH by the heat method, or exact distance.

    Distances are from the nearest of the source points. Without -o, writes <stem>.geodesic.vtk and .png to the current
    directory. With -o, writes those files, and a picture only with --png.

    \b
    Arrays per vertex: heat, divergence, distance (inf on components without a source).
    Arrays per face:   heat_gradient, direction (-grad u / |grad u|).

    The error of the heat method is a few percent, and largest near the source. The report compares the distances with
    exact ones at the 50,000 vertices nearest to the source, except with -q. --refine makes them exact. --method exact
    and fast-marching write the array distance only.

    With --robust, arrays per vertex are computed on the intrinsic Delaunay triangulation. Arrays per face are computed
    from u on the faces of MESH, and are zero on faces of zero area.

    --all-pairs, --pairs and --sources write distances only, one row per set of sources, in memory that does not grow
    with the number of rows. An interrupted run leaves D.partial.npy; the same command resumes it. --all-pairs with
    --limit and -o D.npz writes a sparse symmetric matrix, in which entries are stored within the limit, zeros included.

    With --labels, --all-pairs writes a table with the columns source, target, mean, min and max, one row per pair of
    labels. A vertex belongs to the labels of all its faces. A label and itself are a pair, zeros included.

    \b
    Examples:
      geomhw geodesic data/creature.obj --source 0 -o creature.vtp --png creature.png
      geomhw geodesic data/strip.off --source boundary --source face:17:0.2,0.3,0.5 --no-png
      geomhw geodesic data/creature.obj --all-pairs -o D.npy
      mpirun -n 4 geomhw geodesic huge.ply --engine petsc -o out.pvtu
      geomhw geodesic data/creature.obj --method exact --source 0 --limit 0.5 --beyond -1 -o near.vtp
    """
    if engine == "petsc":
        from geomhw_cli.runtime.mpi_distances import distances_over_ranks

        distances_over_ranks(mesh_path, sources, method["time"], method["bound"], files["outputs"], report)
        return
    labeled = LabelTable.parse(labels, table, all_pairs)
    others = {"--source": sources.specs, **{f"--{kind}": files[kind] for kind in KINDS}}
    for name, value in {"--single": single, "--to": to.specs}.items():
        if labeled and value:
            raise click.UsageError(f"{name} and --labels exclude each other.")
    queries = DistanceQueries.parse(all_pairs, pairs, source_file, to if to.specs else None, single, others)
    chosen = DistanceMethod.parse(method_name, method, limit, has_columns=bool(queries))
    ends, is_dense = [path.suffix.lower() for path in files["outputs"]], single or beyond != inf or bool(to.specs)
    may_be_sparse = all_pairs and not labeled and ends in ([".npz"], [".shard"])
    if may_be_sparse and is_dense and ends == [".npz"]:
        raise click.UsageError("--single, --beyond and --to are not for sparse matrices; give -o D.npy.")
    is_sparse = limit is not None and may_be_sparse and not is_dense
    if (shard or scheduler) and not queries:
        raise click.UsageError("--shard and --scheduler are for --all-pairs, --pairs and --sources.")
    if estimate:
        from geomhw_cli.runtime.estimate import Plan, print_estimate

        draws = not queries and any([*(files[kind] for kind in KINDS), not (files["outputs"] or files["no_png"])])
        is_partial = bool(limit is not None or to.specs or mask)
        has_matrix = queries and not (queries.is_pairs or labeled or is_sparse)
        width = (4 if single else 8) if has_matrix else 0
        plan = Plan(chosen, queries, is_sparse, width, is_partial, draws, report["quiet"], shard or WHOLE)
        print_estimate(mesh_path, plan, report["as_json"])
        return
    if queries:
        job = Job("geodesic", mesh_path, files["outputs"], **report)
        if is_sparse and limit is not None:
            if scheduler:
                raise click.UsageError("--scheduler is not for sparse matrices, which use all cores; give --shard.")
            from geomhw_cli.runtime.sparse_distances import compute_matrix

            compute_matrix(job, chosen, mask, shard or WHOLE)
        else:
            compute_distances(
                job, queries, "<f4" if single else "<f8", chosen, beyond, mask, labeled, shard or WHOLE, scheduler
            )
        return
    job = Job.plan("geodesic", mesh_path, **files, **report)
    if chosen.name == "heat":
        heat_distances(job, mask, sources, chosen, beyond, panels)
    else:
        front_distances(job, mask, sources, to, chosen, beyond, panels)
