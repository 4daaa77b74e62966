"""``geomhw gradient``: the gradient of a function along the surface."""

from typing import Any

from geomhw_cli import options
from geomhw_cli.options import OptionGroup, command
from geomhw_cli.output_options import FIELD_FILES
from geomhw_cli.runtime.job import Job
from geomhw_cli.smooth import MASK
from geomhw_cli.specs.arrays import ARRAY, MESH_ARRAY, MeshArray
from geomhw_cli.specs.masks import MaskSpec, MeshPart


@command(
    OptionGroup("Input", ARRAY, MASK),
    FIELD_FILES,
    options.REPORT,
    arguments=(MESH_ARRAY,),
)
def gradient(
    mesh_array: MeshArray, array: str | None, mask: str | None, files: dict[str, Any], report: dict[str, Any]
) -> None:
    """Compute the gradient of an array on the vertices of MESH.

    On a face, it is that of the linear function between the corners. At a vertex, it is that of a cubic fitted to the
    vertices around, with an error that falls with the cube of the edge length. With --mask, vertices outside are
    not used, and their gradient is zero. Without -o, writes <stem>.gradient.vtk and .png to the current directory.

    \b
    Arrays per vertex: gradient_magnitude, gradient (3 components). Per face: gradient.

    \b
    Examples, in one file and in two:
      geomhw geodesic data/creature.obj -o result.vtp -o lh.surf.gii -o lh.func.gii
      geomhw gradient result.vtp:distance -o g.vtp
      geomhw gradient lh.surf.gii --array lh.func.gii:distance -o lh.gradient.func.gii
    """
    import numpy as np

    from geomhw.errors import FieldError
    from geomhw.operators import gradient_of
    from geomhw.render import scalar_picture
    from geomhw.results import Field, Result
    from geomhw.scalars import vertex_gradient

    job = Job.plan("gradient", mesh_array.path, **files, **report)
    mesh, field = mesh_array.read(job, array)
    values = np.asarray(field.values, dtype=float)
    if values.ndim != 1:
        raise FieldError(f"the array '{field.name}' has {values.shape[1]} components; the gradient is of one number")
    part = MeshPart.of(mesh, MaskSpec.parse(mask))
    with job.stage("compute"):
        on_faces, on_vertices = gradient_of(part.mesh, values), vertex_gradient(part.mesh, values)
        lengths = np.linalg.norm(on_vertices, axis=1)
    arrays = [
        Field("gradient_magnitude", "vertex", lengths),
        Field("gradient", "vertex", on_vertices),
        Field("gradient", "face", on_faces),
    ]
    job.write(part.expand(Result(part.mesh, arrays)), scalar_picture)
    used = part.mesh.vertex_areas
    mean = float(used @ lengths / used.sum())
    at = int(lengths.argmax())
    answers = {"array": field.name, "mean_magnitude": mean, "largest": {"vertex": at, "magnitude": float(lengths[at])}}
    job.finish(mesh, answers, [f"gradient: of {field.name}, {mean:.6g} on average, {lengths[at]:.6g} at vertex {at}"])
