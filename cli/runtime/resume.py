"""The state of a fluid run beside its series, and how to go on from it."""

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geomhw_cli.runtime.frame_writer import FrameWriter

if TYPE_CHECKING:
    from geomhw.fluid.state import FlowState
    from geomhw.mesh.triangle_mesh import TriangleMesh

_ARRAYS = {"color", "rows", "frame_times"}


def save_state(writer: FrameWriter, mesh: "TriangleMesh", state: "FlowState", choices: dict[str, Any]) -> None:
    """Write what another run needs to go on from this state to the same numbers."""
    import numpy as np

    from geomhw.io import write_checkpoint

    description = {
        "run": _run_of(choices),
        "mesh": _digest(mesh),
        "step": state.step,
        "time": state.time,
        "columns": list(writer.rows[0]),
    }
    arrays = {f"memory_{name}": values for name, values in state.variables.items()}
    arrays["color"] = state.color
    arrays["rows"] = np.array([list(row.values()) for row in writer.rows])
    arrays["frame_times"] = np.array([frame.time for frame in writer.series.frames])
    write_checkpoint(writer.checkpoint, description, arrays)


def resumed(writer: FrameWriter, mesh: "TriangleMesh", path: Path, choices: dict[str, Any]) -> "FlowState":
    """The state of an earlier run; its frames up to there, and their table, become this run's.

    FormatError if it is of another mesh, another run, or not of this series.
    """
    from geomhw.errors import FormatError
    from geomhw.fluid.state import FlowState
    from geomhw.io import read_checkpoint, read_series

    description, arrays = read_checkpoint(path)
    wanted = {"run": dict, "mesh": str, "step": int, "time": float, "columns": list}
    whole = all(isinstance(description.get(name), kind) for name, kind in wanted.items())
    if not whole or not arrays.keys() >= _ARRAYS:
        raise FormatError(f"{path.name} holds no state of a fluid; give the .restart.npz of an earlier run")
    ours = _run_of(choices)
    for name in sorted(description["run"].keys() | ours.keys()):
        if ours.get(name) != (value := description["run"].get(name)):
            raise FormatError(f"{path.name} is of a run with {name} = {value}, not {ours.get(name)}; start anew")
    if description["mesh"] != _digest(mesh):
        raise FormatError(f"{path.name} is of a run on another mesh; start anew")
    variables = {name.removeprefix("memory_"): values for name, values in arrays.items() if name.startswith("memory_")}
    state = FlowState(description["step"], description["time"], arrays["color"], variables)
    if state.step == 0:
        return state  # the frame of the start will be written again
    kept = arrays["frame_times"].tolist()
    frames = read_series(writer.series.path)[: len(kept)]
    if [frame.time for frame in frames] != kept:
        raise FormatError(
            f"{writer.series.path.name} does not hold the frames that {path.name} goes on from; start anew"
        )
    writer.series.frames[:] = frames
    for row in arrays["rows"].tolist():
        named = dict(zip(description["columns"], row, strict=True))
        writer.rows.append(named | {"step": int(named["step"])})
    return state


def _run_of(choices: dict[str, Any]) -> dict[str, Any]:
    """What must be the same for a run to be the continuation of another."""
    return {name: value for name, value in choices.items() if name not in ("steps", "until")}


def _digest(mesh: "TriangleMesh") -> str:
    return hashlib.sha256(mesh.vertices.tobytes() + mesh.faces.tobytes()).hexdigest()
