"""Checkpoints of a fluid run: written beside its series, read to resume the run."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from geomhw_cli.runtime.frame_writer import FrameWriter

if TYPE_CHECKING:
    from geomhw.fluid.state import FlowState
    from geomhw.mesh.triangle_mesh import TriangleMesh

_VALUES = {"run": dict, "mesh": str, "step": int, "time": float, "columns": list}
#: Options that a run may change when it goes on.
END = ("steps", "until")
_ARRAYS = {"color", "rows", "frame_times"}


def save_state(writer: FrameWriter, mesh: "TriangleMesh", state: "FlowState", choices: dict[str, Any]) -> None:
    """Write all that another run needs to continue from this state to the same numbers."""
    import numpy as np

    from geomhw.io import write_checkpoint

    description = {
        "run": _identity(choices),
        "end": {name: choices[name] for name in END},
        "mesh": mesh.digest,
        "step": state.step,
        "time": state.time,
        "columns": list(writer.rows[0]),
    }
    arrays = {f"memory_{name}": values for name, values in state.variables.items()}
    arrays["color"] = state.color
    arrays["rows"] = np.array([list(row.values()) for row in writer.rows])
    arrays["frame_times"] = np.array([frame.time for frame in writer.series.frames])
    write_checkpoint(writer.checkpoint, description, arrays)


def load_state(writer: FrameWriter, mesh: "TriangleMesh", path: Path, choices: dict[str, Any]) -> "FlowState":
    """Read the state of an earlier run, and give the writer the frames and table rows up to there.

    Raises FormatError if the state is of another mesh, another run, or another series.
    """
    from geomhw.errors import FormatError
    from geomhw.fluid.state import FlowState
    from geomhw.io import read_checkpoint, read_series

    description, arrays = read_checkpoint(path)
    is_whole = all(isinstance(description.get(name), kind) for name, kind in _VALUES.items())
    if not is_whole or not arrays.keys() >= _ARRAYS:
        raise FormatError(f"{path.name} holds no state of a fluid; give the .restart.npz of an earlier run")
    ours, theirs = _identity(choices), description["run"]
    for name in sorted(theirs.keys() | ours.keys()):
        if (value := theirs.get(name)) != ours.get(name):
            raise FormatError(f"{path.name} is of a run with {name} = {value}, not {ours.get(name)}; start anew")
    if description["mesh"] != mesh.digest:
        raise FormatError(f"{path.name} is of a run on another mesh; start anew")
    if not _is_sound(description, arrays, mesh.n_vertices):
        raise FormatError(f"{path.name} holds a state that no run can have; start anew")
    variables = {name.removeprefix("memory_"): values for name, values in arrays.items() if name.startswith("memory_")}
    state = FlowState(description["step"], description["time"], arrays["color"], variables)
    if state.step == 0:
        return state  # the run writes the first frame again
    times = arrays["frame_times"].tolist()
    frames = read_series(writer.series.path)[: len(times)]
    if [frame.time for frame in frames] != times:
        raise FormatError(f"{writer.series.path.name} lacks the frames before the state in {path.name}; start anew")
    writer.series.frames[:] = frames
    for row in arrays["rows"].tolist():
        values = dict(zip(description["columns"], row, strict=True))
        writer.rows.append(values | {"step": int(values["step"])})
    return state


def _is_sound(description: dict[str, Any], arrays: dict[str, Any], n: int) -> bool:
    """Whether numbers are finite and not negative where they count, and arrays have the shapes that belong together."""
    import numpy as np

    color, rows, times = (arrays[name] for name in ("color", "rows", "frame_times"))
    return (
        not isinstance(description["step"], bool)
        and description["step"] >= 0 <= description["time"] < np.inf
        and all(values.dtype.kind in "fiu" for values in arrays.values())
        and all(np.isfinite(values).all() for values in (color, times))
        and color.shape[:1] == (n,)
        and rows.shape == (len(times), len(description["columns"]))
        and "step" in description["columns"]
    )


def _identity(choices: dict[str, Any]) -> dict[str, Any]:
    """The options that a run must share with the run that it continues."""
    return {name: value for name, value in choices.items() if name not in END}
