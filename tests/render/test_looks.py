"""Choices for pictures: views, colors, isolines, transparency, sizes, and vector files."""

import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from geomhw.errors import ArgumentError, FieldError
from geomhw.mesh import genus_two, primitives
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.canvas import Text
from geomhw.render.colors import round_below, round_spacing, shade
from geomhw.render.layers import Curves, Marker, Panel, Surface
from geomhw.render.look import Look
from geomhw.render.panels import draw, save_vector
from geomhw.render.view import choose_view, guess_up, landmarks
from support.pictures import count, needs_opengl
from support.program import run, save_off

BALL = primitives.icosphere(2)
X, Y, Z = np.eye(3)


def lying(mesh: TriangleMesh) -> TriangleMesh:
    """Turn the y axis to z."""
    return TriangleMesh(mesh.vertices[:, [2, 0, 1]], mesh.faces)


def statue() -> TriangleMesh:
    """Return a ball on a broad flat base, upright along y."""
    base = primitives.icosphere(3).vertices * [1.5, 0.2, 1.5]
    base[:, 1] = np.maximum(base[:, 1], -0.1)
    ball = primitives.icosphere(3)
    points = np.concatenate([base, ball.vertices + np.array([0.1, 1.0, 0.2])])
    return TriangleMesh(points, np.concatenate([ball.faces, ball.faces + ball.n_vertices]))


# -- views -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("view", "up", "right", "above", "toward"),
    [
        ("front", "y", X, Y, Z),
        ("back", "y", -X, Y, -Z),
        ("right", "y", -Z, Y, X),
        ("left", "y", Z, Y, -X),
        ("top", "y", X, -Z, Y),
        ("bottom", "y", X, Z, -Y),
        ("front", "z", X, Z, -Y),
        ("right", "z", Y, Z, X),
        ("top", "z", X, Y, Z),
        ("front", "x", Z, X, Y),
        ("90,0", "y", -Z, Y, X),
        ("0,90", "y", X, -Z, Y),
        ("-45,0", "y", (X + Z) / np.sqrt(2), Y, (Z - X) / np.sqrt(2)),
    ],
)
def test_named_views(view: str, up: str, right: np.ndarray, above: np.ndarray, toward: np.ndarray) -> None:
    """Named views and angles give the axes right, up and toward the viewer."""
    axes = choose_view(BALL, look=Look(view, up)).axes
    np.testing.assert_allclose(axes, [right, above, toward], atol=1e-12)


@pytest.mark.parametrize("view", ["north", "1", "1,2,3", "0,91", "400,0", "nan,0", "1e3,0"])
def test_views_that_are_none(view: str) -> None:
    """Other names, and angles out of range, are refused."""
    with pytest.raises(ArgumentError, match="is no view"):
        choose_view(BALL, look=Look(view))


def test_zoom() -> None:
    """A zoom of two halves the part of the mesh that fits into the panel."""
    np.testing.assert_allclose(2 * choose_view(BALL, look=Look(zoom=2)).extent, choose_view(BALL).extent)


def test_up_is_where_the_base_is_not() -> None:
    """A statue on a base is upright whether it stands along y or along z; --up overrides the guess."""
    for scale, shift in ((1.0, 0.0), (1e-6, 0.0), (1e3, 1e5)):
        mesh = TriangleMesh(statue().vertices * scale + shift, statue().faces)
        np.testing.assert_array_equal(guess_up(mesh), Y)
        np.testing.assert_array_equal(guess_up(lying(mesh)), Z)
    assert choose_view(lying(statue()), look=Look()).axes[1] @ Z > 0.8
    assert choose_view(lying(statue()), look=Look(up="y")).axes[1] @ Y > 0.4


def test_holes_are_seen() -> None:
    """Holes are seen through, however the mesh lies."""
    for mesh in (genus_two(24), lying(genus_two(24)), primitives.torus(40, 20), lying(primitives.torus(40, 20))):
        _, _, thin = np.linalg.svd(mesh.vertices - mesh.vertices.mean(axis=0), full_matrices=False)[2]
        assert abs(choose_view(mesh).axes[2] @ thin) > 0.5


def test_one_view_for_all_commands() -> None:
    """The default source gives the view that is chosen without a source."""
    top = int(statue().vertices[:, 1].argmax())
    assert landmarks(statue()) == landmarks(statue(), [top])
    views = [choose_view(statue(), landmarks(statue(), sources)) for sources in ([], [top])]
    np.testing.assert_array_equal(views[0].axes, views[1].axes)


# -- colors ------------------------------------------------------------------------------------------------------


def test_isolines_by_number_and_spacing() -> None:
    """An int is a number of isolines; a float is their spacing, at its multiples."""
    values = np.linspace(0.3, 2.3, BALL.n_vertices)
    found = [shade(Surface(values, isolines=lines), BALL) for lines in (4, 0.5, 0)]
    np.testing.assert_allclose(0.3 + 2 * found[0].levels, [0.7, 1.1, 1.5, 1.9])
    np.testing.assert_allclose(0.3 + 2 * found[1].levels, [0.5, 1.0, 1.5, 2.0])
    assert (found[0].spacing, found[1].spacing, len(found[2].levels)) == (pytest.approx(0.4), 0.5, 0)
    with pytest.raises(FieldError, match="isolines"):
        shade(Surface(values, isolines=1e-6), BALL)


@pytest.mark.parametrize(("extent", "spacing"), [(66.9, 4.0), (1.0, 0.05), (2e-7, 1e-8), (1e5, 5e3)])
def test_round_spacing(extent: float, spacing: float) -> None:
    """Spacings are round and give at most twenty lines."""
    assert round_spacing(extent) == pytest.approx(spacing)


@pytest.mark.parametrize(("value", "below"), [(1.4, 1), (1.0, 1), (0.99, 0.5), (47, 20), (6e-8, 5e-8)])
def test_round_below(value: float, below: float) -> None:
    """Keys of arrows are 1, 2 or 5 times a power of ten."""
    assert round_below(value) == pytest.approx(below)


@needs_opengl
def test_colors_on_the_surface_are_those_of_the_bar() -> None:
    """Where the surface faces the viewer, its color is that of the bar."""
    flat = primitives.grid(4, 4)
    for value in (0.0, 0.5, 1.0):
        surface = Surface(np.full(flat.n_vertices, value), limits=(0, 1), bar=False)
        seen = draw(flat, [Panel(surface=surface)], (100, 100))[50, 50].astype(int)
        shades = shade(surface, flat)
        np.testing.assert_allclose(seen, shades.table[round(255 * value)][:3], atol=2)


@needs_opengl
def test_look_changes_the_main_quantity() -> None:
    """Color map, range and isolines apply to the main surface only."""
    height = Surface(BALL.vertices[:, 1], label="height")
    aside = Surface(BALL.vertices[:, 0], label="aside", main=False)
    look = Look(colormap="cividis", limits=(-2.0, 2.0), isolines=0.5, width=240)
    texts = [item.text for item in draw(BALL, [Panel("a", height), Panel("b", aside)], look=look).canvas.items
             if isinstance(item, Text)]  # fmt: skip
    assert "height, isolines every 0.5" in texts
    assert "aside" in texts
    assert {"−2", "2"} <= set(texts)
    with pytest.raises(FieldError, match="no color map 'none'"):
        draw(BALL, [Panel("a", height)], look=Look(colormap="none"))


# -- sizes and files ---------------------------------------------------------------------------------------------


@needs_opengl
def test_texts_scale_with_the_width() -> None:
    """Texts grow with the width, and have at least ten pixels."""
    sizes = []
    for width in (120, 600, 1200):
        picture = draw(BALL, [Panel("title", Surface(BALL.vertices[:, 1], label="height"))], look=Look(width=width))
        sizes.append(np.array([item.size for item in picture.canvas.items if isinstance(item, Text)]))
    assert min(map(min, sizes)) >= 10
    np.testing.assert_allclose(sizes[2], 2 * sizes[1], rtol=0.1)


@needs_opengl
def test_transparent_background() -> None:
    """A transparent picture is opaque where the mesh is, and over white it is the plain one."""
    panel = Panel(surface=Surface(BALL.vertices[:, 1], bar=False))
    clear = draw(BALL, [panel], (200, 200), look=Look(transparent=True))
    plain = draw(BALL, [panel], (200, 200))
    assert clear.shape == (200, 200, 4)
    assert (clear[2, 2, 3], clear[100, 100, 3]) == (0, 255)
    opacity = clear[..., 3:] / 255
    np.testing.assert_allclose(clear[..., :3] * opacity + 255 * (1 - opacity), plain, atol=3)


@needs_opengl
def test_hidden_marks_have_a_word() -> None:
    """The first mark that the surface hides is labeled as behind it."""
    depth = BALL.vertices @ choose_view(BALL).axes[2]
    marks = [Marker(int(depth.argmax()), "near"), Marker(int(depth.argmin()), "far")]
    texts = [item.text for item in draw(BALL, [Panel(markers=marks)]).canvas.items if isinstance(item, Text)]
    assert texts == ["near", "far (behind)"]


@needs_opengl
def test_vectors_of_marks() -> None:
    """The vector of a mark is drawn in front of everything, with its length."""
    front = int((BALL.vertices @ choose_view(BALL).axes[2]).argmax())
    right = choose_view(BALL).axes[0]
    ink = [
        count(
            draw(BALL, [Panel(markers=[Marker(front, color="#ff00ff", vector=length * right)])], (300, 300)), "#ff00ff"
        )
        for length in (0.0, 0.2, 0.4)
    ]
    assert ink[2] - ink[1] == pytest.approx(0.2 * 300 * 0.24 * 10, rel=0.35)
    assert ink[1] > ink[0] + 100


@needs_opengl
@pytest.mark.parametrize("kind", ["svg", "pdf"])
def test_vector_files(kind: str, tmp_path: Path) -> None:
    """Texts of SVG and PDF are texts, and equal pictures give equal bytes."""
    panel = Panel("a title", Surface(BALL.vertices[:, 1], label="height"), markers=[Marker(3, "here")])
    picture = draw(BALL, [panel], look=Look(width=240))
    for name in ("a", "b"):
        save_vector(tmp_path / f"{name}.{kind}", picture, 100.0, "as drawn")
    data = (tmp_path / f"a.{kind}").read_bytes()
    assert data == (tmp_path / f"b.{kind}").read_bytes()
    if kind == "svg":
        text = data.decode()
        texts = set(re.findall(r">([^<>\n]+)</text>", text))
        assert {"a title", "height"} <= texts
        assert any(text.startswith("here") for text in texts)
        assert text.count("<image") == 1
    else:
        assert b"as drawn" in data


@needs_opengl
def test_curves_of_a_width() -> None:
    """Curves are as wide as they say, and hidden behind the surface."""
    flat = primitives.grid(4, 4)
    segment = np.array([[[0.2, 0.5, 0.0], [0.8, 0.5, 0.0]]])
    for width in (3.0, 9.0):
        image = draw(flat, [Panel(curves=[Curves(segment, "#ff00ff", width)])], look=Look("top", "z", width=600))
        column = count(image[:, 290:310], "#ff00ff", 60) / 20
        assert column == pytest.approx(width, abs=1.01)


# -- the command line --------------------------------------------------------------------------------------------


@needs_opengl
def test_options_of_pictures(folder: Path) -> None:
    """A picture has the resolution, opacity, command line and version in its file."""
    save_off(BALL)
    options = (
        "--view front --up z --zoom 0.5 --width 150 --dpi 300 --transparent --isolines 5 --range 0,4 --colormap magma"
    )
    arguments = ["geodesic", "ball.off", "-o", "a.vtk", "--png", "a.png", "--svg", "a.svg", "--pdf", "a.pdf"]
    answer = run(*arguments, *options.split())
    assert answer.exit_code == 0, answer.stderr
    with Image.open("a.png") as picture:
        assert picture.mode == "RGBA"
        assert picture.info["dpi"] == pytest.approx((300, 300), abs=0.1)
        assert "--zoom 0.5" in picture.text["Description"]
    assert {"a.svg", "a.pdf"} <= {path.name for path in folder.iterdir()}


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--view", "up"), ("--view", "10,100"), ("--up", "w"), ("--zoom", "0"), ("--dpi", "0"), ("--range", "2,1"),
        ("--range", "1"), ("--isolines", "-1"), ("--isolines", "many"), ("--colormap", "sunset"),
    ],
)  # fmt: skip
def test_wrong_options_of_pictures(option: str, value: str, folder: Path) -> None:
    """Wrong values are refused before the computation, with what is right."""
    save_off(BALL)
    answer = run("geodesic", "ball.off", option, value)
    assert answer.exit_code == 2
    assert value in answer.stderr
    assert [path.name for path in folder.iterdir()] == ["ball.off"]
