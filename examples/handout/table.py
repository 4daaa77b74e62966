"""The numbers of the page, from the reports and results of a run: a table in Markdown.

python table.py FOLDER TIME...
"""

import json
import sys
from pathlib import Path

import numpy as np

import geomhw
from geomhw.operators import divergence

folder, times = Path(sys.argv[1]), sys.argv[2:]
report = {path.stem: json.loads(path.read_text()) for path in folder.glob("*.json")}


def array(name: str, field: str) -> np.ndarray:
    return np.asarray(geomhw.read(folder / f"{name}.vtp")[field])


def percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def row(problem: str, what: str, value: str) -> None:
    print(f"| {problem} | {what} | {value} |")


def error(name: str) -> str:
    exact, found = array("exact", "distance"), array(name, "distance")
    away = exact > 0
    return percent(np.mean(np.abs(found - exact)[away] / exact[away]))


def angle_between(one: np.ndarray, other: np.ndarray) -> float:
    """Mean angle in degrees."""
    cosine = (one * other).sum(axis=1) / np.linalg.norm(one, axis=1) / np.linalg.norm(other, axis=1)
    return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean())


print("| problem | what | value |\n|---|---|---|")
mesh, heat = report["heat"]["mesh"], report["heat"]
row("", "vertices, faces", f"{mesh['vertices']:,}, {mesh['faces']:,}")
row("", "mean edge length h", f"{mesh['mean_edge_length']:.6g}")

shares = report["parts"]["energy_shares"]
Div = divergence(geomhw.read(folder / "parts.vtp").mesh)
before, after = (np.abs(Div @ array("parts", name).ravel()).max() for name in ("field", "divergence_free"))
row("1b", "energy of V in ∇ζ, in V - ∇ζ", f"{percent(shares['curl_free'])}, {percent(shares['divergence_free'])}")
row(
    "1b",
    "largest divergence of V - ∇ζ, as a share of that of V",
    "at most 10⁻¹²" if after < 1e-12 * before else f"{after / before:.0e}",
)

for time in times:
    far = report[f"time_{time}"]["farthest"]["distance"]
    row("2a", f"t = {time} h²: mean error, distance of the farthest", f"{error(f'time_{time}')}, {far:.4g}")
row("2c", "time that heat flows, t", f"{heat['time']['t']:.6g} = {heat['time']['t_over_h2']:.3g} h²")
farthest = heat["farthest"]
row("2e", "source", str(heat["sources"][0]))
row("2e", "farthest vertex", str(farthest["vertex"]))
row("2e", "its distance", f"{farthest['distance']:.10g}")
row("2e", "its distance by --refine", f"{array('exact', 'distance')[farthest['vertex']]:.4g}")

short, long = (array("transport", f"transported_{k}") for k in (0, -1 + len(report["transport"]["times"])))
dts = [f"{time['t_over_h2']:.4g}" for time in report["transport"]["times"]]
row("3b", f"mean angle between the fields of dt = {dts[0]} h² and {dts[-1]} h²", f"{angle_between(short, long):.1f}°")

for name in ("damping", "damping_long"):
    run = report[name]
    row(
        "4c",
        f"energy left after 66 steps of dt = {run['dt']:g}",
        percent(run["last"]["energy"] / run["first"]["energy"]),
    )
row(
    "4e",
    "largest divergence after a projection",
    "at most 10⁻¹²" if report["damping"]["last"]["divergence"] < 1e-12 else "?",
)
