"""Figures of the operator approach: ``python fields.py -o OUT`` writes bracket.png, killing.png and design.png.

It prints how close each is to what is known.
"""

import argparse
from pathlib import Path

import numpy as np

from geomhw.directions import DirectionFields, joint_fields
from geomhw.flow import FieldDerivatives, energy, rigid_field
from geomhw.io import read_mesh, write_png
from geomhw.mesh import TriangleMesh, cylinder_band
from geomhw.render import Look, bracket_picture, direction_picture, killing_picture
from geomhw.results import Field, Result
from geomhw.spectral import killing_fields

LOOK = Look(width=420)
DATA = Path(__file__).parents[2] / "data"


def bracket_of_rotations(out: Path) -> None:
    """The bracket of the rotations about x and y is that about z, with a minus."""
    mesh = read_mesh(DATA / "sphere.off")
    X, Y, Z = (rigid_field(mesh, axis) for axis in np.eye(3))
    found = FieldDerivatives(mesh).bracket(X, Y)
    error = np.sqrt(energy(mesh, found + Z) / energy(mesh, Z))
    print(f"[X, Y] = -Z up to {100 * error:.2f} % on {mesh.n_vertices} vertices")
    fields = [Field(name, "face", V) for name, V in (("first", X), ("second", Y), ("bracket", found))]
    write_png(out / "bracket.png", bracket_picture(Result(mesh, fields), LOOK))


def bent_cylinder() -> TriangleMesh:
    """Return an open cylinder over a curve with a dent, as from a flat sheet: its metric is flat."""
    band = cylinder_band(90, 20, height=1.6)
    angle = np.arctan2(band.vertices[:, 1], band.vertices[:, 0])
    radius = 1 + 0.35 * np.cos(2 * angle) + 0.2 * np.cos(3 * angle)
    return TriangleMesh(np.stack([radius * np.cos(angle), radius * np.sin(angle), band.vertices[:, 2]], 1), band.faces)


def killing_field(out: Path) -> None:
    """A bent cylinder has the rotation of a round one: a field of constant length along its curve."""
    mesh = bent_cylinder()
    result = killing_fields(mesh, 2)
    length = np.linalg.norm(np.asarray(result["killing_0"]), axis=1)
    gap, shares = result.report["gap"], result.report["shares"]
    print(f"bent cylinder: {gap['fields']} Killing field, the next energy is {gap['ratio']:.0e} times as large")
    print(f"length varies by {100 * np.ptp(length) / length.mean():.1e} %, coexact {100 * shares['coexact'][0]:.2f} %")
    write_png(out / "killing.png", killing_picture(result, LOOK))


def field_on_two_shapes(out: Path) -> None:
    """A lying and a standing egg with the same vertices: designed at once, the map takes one field to the other."""
    ball = read_mesh(DATA / "sphere.off")
    x, y, z = ball.vertices.T
    lying = TriangleMesh(np.stack([1.5 * x, y * (1 - 0.2 * x), z * (1 - 0.2 * x)], 1), ball.faces)
    standing = TriangleMesh(np.stack([x * (1 - 0.2 * z), y * (1 - 0.2 * z), 1.5 * z], 1), ball.faces)
    one, other = DirectionFields(lying), DirectionFields(standing)
    u, v = joint_fields(one, other, np.arange(ball.n_vertices))
    apart = [
        _turn(lying, standing, one.result(p), other.result(q))
        for p, q in ((one.smoothest(), other.smoothest()), (u, v))
    ]
    print(f"median angle between one field and the image of the other: {apart[0]:.0f}° alone, {apart[1]:.0f}° at once")
    pictures = [direction_picture(fields.result(w), LOOK) for fields, w in ((one, u), (other, v))]
    height = min(len(picture) for picture in pictures)
    write_png(out / "design.png", np.concatenate([picture[:height] for picture in pictures], axis=1))


def _turn(mesh: TriangleMesh, onto: TriangleMesh, first: Result, second: Result) -> float:
    """Median angle in degrees between the second field and the image of the first, along the edges of the meshes."""
    i, j = mesh.edges.T
    one, other = np.asarray(first["direction"]), np.asarray(second["direction"])
    # Least squares: the linear map of the edges at each vertex, which takes those of one to those of the other.
    before, after = mesh.vertices[j] - mesh.vertices[i], onto.vertices[j] - onto.vertices[i]
    normal, image = np.zeros((2, mesh.n_vertices, 3, 3))
    for end in (i, j):
        np.add.at(normal, end, np.einsum("ex,ey->exy", before, before))
        np.add.at(image, end, np.einsum("ex,ey->exy", after, before))
    moved = np.einsum("vxy,vyz,vz->vx", image, np.linalg.pinv(normal, rcond=1e-3), one)
    cosine = np.einsum("vx,vx->v", moved, other) / np.linalg.norm(moved, axis=1)
    return float(np.median(np.degrees(np.arccos(np.clip(cosine, -1, 1)))))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=Path("out"), help="folder of the pictures")
    out = parser.parse_args().output
    out.mkdir(parents=True, exist_ok=True)
    bracket_of_rotations(out)
    killing_field(out)
    field_on_two_shapes(out)
