"""Pictures: surfaces, arrows, markers, isolines and text are visible, deterministic and independent of scale."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import ndimage

from geomhw.errors import FieldError
from geomhw.mesh import primitives
from geomhw.mesh.named_points import vertex_points
from geomhw.mesh.triangle_mesh import TriangleMesh
from geomhw.render.layers import DARK, Arrows, Marker, Panel, Surface
from geomhw.render.look import Look
from geomhw.render.panels import Drawing, draw
from geomhw.render.pictures import geodesic_picture, helmholtz_picture
from geomhw.render.scene import SUPERSAMPLING, Stage
from geomhw.render.view import View, choose_view
from geomhw.results import Field, Result
from support.pictures import count, needs_opengl

SIZE = (300, 300)
BALL = primitives.icosphere(3)
HEIGHT = BALL.vertices[:, 1]
#: Hues that nothing else in a picture has.
MAGENTA, GREEN = "#ff00ff", "#00c000"


def picture(*panels, mesh=BALL, **options):
    return draw(mesh, panels, SIZE, **options).astype(int)


def geodesic_result(mesh=BALL):
    """Return the heat method's fields on a sphere in closed form, from its highest vertex."""
    radius = np.linalg.norm(mesh.vertices - mesh.vertices.mean(axis=0), axis=1).mean()
    y = (mesh.vertices[:, 1] - mesh.vertices[:, 1].mean()) / radius
    distance = radius * np.arccos(np.clip(y / y.max(), -1, 1))
    down = np.array([0.0, -1.0, 0.0]) - (mesh.face_normals @ [0.0, -1.0, 0.0])[:, None] * mesh.face_normals
    direction = down / np.linalg.norm(down, axis=1, keepdims=True)
    fields = [
        Field("heat", "vertex", np.exp(-20 * distance / radius)),
        Field("divergence", "vertex", np.cos(distance / radius)),
        Field("distance", "vertex", distance),
        Field("direction", "face", direction),
        Field("heat_gradient", "face", -direction * np.exp(-20 * distance[mesh.faces].mean(axis=1))[:, None]),
    ]
    far = int(distance.argmax())
    report = {"farthest": {"vertex": far, "distance": float(distance[far])}}
    return Result(mesh, fields, report, vertex_points(mesh, [int(y.argmax())]))


# -- layers ------------------------------------------------------------------------------------------------------


@needs_opengl
def test_surface_fits_the_panel():
    """The sphere fills its panel up to the margin, centered on white."""
    image = picture(Panel())
    rows, columns = np.nonzero((image != 255).any(axis=2))
    assert image.shape == (300, 300, 3)
    for low, high in ((rows.min(), rows.max()), (columns.min(), columns.max())):
        assert 275 < high - low < 290
        assert abs(low + high - 299) <= 2


@needs_opengl
def test_values_become_colors():
    """Low values have the lower end of the color map, high values the upper end."""
    image = picture(Panel(surface=Surface(HEIGHT, colormap="RdBu_r", bar=False)))
    top, bottom = image[40, 150], image[260, 150]
    assert top[0] > top[2] + 50
    assert bottom[2] > bottom[0] + 50


@needs_opengl
def test_values_per_face():
    """One face with another value changes as many pixels as its projection has."""
    values = np.zeros(BALL.n_faces)
    facing = int((BALL.face_normals @ choose_view(BALL).axes[2]).argmax())
    plain = picture(Panel(surface=Surface(values, "face", limits=(0, 1), bar=False)))
    values[facing] = 1
    hot = picture(Panel(surface=Surface(values, "face", limits=(0, 1), bar=False)))
    changed = (plain != hot).any(axis=2).sum()
    projected = BALL.face_areas[facing] * (300 * 0.94 / 2) ** 2
    assert changed == pytest.approx(projected, rel=0.3)


@needs_opengl
def test_colors_per_vertex():
    """RGB as floats and as bytes draw the same picture."""
    rgb = np.zeros((BALL.n_vertices, 3))
    rgb[:, 1] = 1
    image = picture(Panel(surface=Surface(rgb)))
    as_bytes = picture(Panel(surface=Surface((rgb * 255).astype(np.uint8))))
    np.testing.assert_array_equal(image, as_bytes)
    assert image[150, 150, 1] > 150
    assert image[150, 150, [0, 2]].max() < 60


@needs_opengl
def test_arrows_are_drawn_and_thinned():
    """A wider spacing draws fewer arrows."""
    arrows = Arrows(geodesic_result()["direction"], color=MAGENTA)

    def seen(*layers):
        """Count separate spots of ink."""
        image = picture(Panel(arrows=layers))
        return ndimage.label(np.abs(image - [255, 0, 255]).max(axis=2) < 120)[1]

    assert seen() == 0
    close, loose = seen(replace(arrows, spacing=0.06)), seen(replace(arrows, spacing=0.12))
    assert close > 100
    assert loose == pytest.approx(close / 4, rel=0.3)


@needs_opengl
def test_arrow_length_follows_magnitude():
    """With a scale, half the magnitude gives half the length."""
    result = geodesic_result()
    ink = [
        count(
            picture(Panel(arrows=[Arrows(f * result["direction"], color=MAGENTA, scale=1.0, spacing=0.2)]))[
                60:180, 60:240
            ],
            MAGENTA,
            120,
        )
        for f in (1.0, 0.5, 0.0)
    ]
    assert ink[1] == pytest.approx(ink[0] / 4, rel=0.25)
    assert ink[2] == 0


@needs_opengl
def test_arrows_at_vertices():
    """Arrows can stand at vertices."""
    down = np.tile([0.0, -1.0, 0.0], (BALL.n_vertices, 1))
    assert count(picture(Panel(arrows=[Arrows(down, "vertex", MAGENTA)])), MAGENTA) > 300


@needs_opengl
def test_marker_in_front_and_behind():
    """A visible vertex has a disc, a hidden one a ring."""
    depth = BALL.vertices @ choose_view(BALL).axes[2]
    view = choose_view(BALL)
    front, back = int(depth.argmax()), int(depth.argmin())
    seen, hidden = (picture(Panel(markers=[Marker(v, color=GREEN)]), view=view) for v in (front, back))
    assert count(seen, GREEN) > 35
    assert count(hidden, GREEN) > count(seen, GREEN)  # the word "behind"
    with Stage(BALL, SIZE, view) as stage:
        column, row = np.floor(stage.pixels(BALL.vertices[[front]])[0]).astype(int)
        other, there = np.floor(stage.pixels(BALL.vertices[[back]])[0]).astype(int)
    assert count(seen[row : row + 1, column : column + 1], GREEN) == 1
    assert count(hidden[there : there + 1, other : other + 1], GREEN) == 0
    assert count(hidden[there - 5 : there + 6, other - 5 : other + 6], GREEN) > 10


@needs_opengl
def test_labels_are_drawn_inside_the_panel():
    """Labels at the border are not cut off."""
    view = choose_view(BALL)
    right, middle = int((BALL.vertices @ view.axes[0]).argmax()), int((BALL.vertices @ view.axes[2]).argmax())
    ink = [
        count(picture(Panel(markers=[Marker(v, text, GREEN)]), view=view), GREEN, 60)
        for v, text in ((middle, ""), (middle, "farthest 765"), (right, "farthest 765"))
    ]
    assert ink[1] > ink[0] + 100
    assert ink[2] == pytest.approx(ink[1], rel=0.2)


@needs_opengl
def test_isolines():
    """Isolines are dark, and twice as many give twice the ink."""
    dark = [
        (picture(Panel(surface=Surface(HEIGHT, span=(0.8, 1.0), isolines=k, bar=False))).max(axis=2) < 100).sum()
        for k in (0, 5, 10)
    ]
    assert dark[0] == 0
    assert dark[1] > 300
    assert dark[2] == pytest.approx(2 * dark[1], rel=0.35)


@needs_opengl
def test_unreachable_is_gray():
    """Vertices at infinite distance are gray."""
    shift = np.array([3.0, 0, 0])
    mesh = TriangleMesh(
        np.concatenate([BALL.vertices, BALL.vertices + shift]), np.concatenate([BALL.faces, BALL.faces + 642])
    )
    distance = np.concatenate([np.arccos(np.clip(HEIGHT, -1, 1)), np.full(642, np.inf)])
    view = View(np.eye(3), shift / 2, np.array([2.5, 1.0]))
    image = draw(mesh, [Panel(surface=Surface(distance, isolines=5, bar=False))], (600, 300), 1, view).astype(int)
    near, far = image[:, :300], image[:, 300:]
    assert (np.ptp(near, axis=2) > 30).sum() > 0.5 * (near.min(axis=2) < 250).sum() > 5000
    assert (np.ptp(far, axis=2) > 30).sum() == 0
    assert (far.max(axis=2) < 250).sum() > 5000


@needs_opengl
def test_title_bar_and_note_take_their_room():
    """Title, color bar and note do not overlap the mesh."""
    surface = Surface(np.zeros(BALL.n_vertices), colormap="gray", limits=(-1, 1))
    image = picture(Panel("a title", surface, note="a note"))
    ink = (image.min(axis=2) < 250).any(axis=1)
    assert ink[:25].any()
    assert ink[-20:].any()
    # Between title, mesh, bar and note lie empty rows: at least four blocks of ink, so three gaps.
    assert np.count_nonzero(np.diff(ink.astype(int)) == 1) >= 3


@needs_opengl
def test_dark_theme():
    """The dark theme has a dark background and visible arrows."""
    image = picture(
        Panel("title", arrows=[Arrows(geodesic_result()["direction"], color="#ffe000")]), look=Look(theme=DARK)
    )
    assert image[-1, 0].max() < 40
    assert count(image, "#ffe000") > 300


# -- whole pictures ----------------------------------------------------------------------------------------------


@needs_opengl
def test_geodesic_picture_shows_what_it_should():
    """The panels have arrows; both ends of a diverging map; isolines and labels."""
    image = geodesic_picture(geodesic_result(), size=(900, 360)).astype(int)
    heat, divergence, distance = image[:, :300], image[:, 300:600], image[:, 600:]
    body = slice(40, 300)
    assert count(heat[body], "#14171c", 40) > 500
    assert (divergence[body, :, 0] - divergence[body, :, 2] > 60).any()
    assert (divergence[body, :, 2] - divergence[body, :, 0] > 60).any()
    assert count(distance[body], "#14171c", 40) > 500
    assert count(distance, "#c2185b") > 30
    assert count(distance, "#0b57d0") > 30
    assert count(divergence, "#c2185b") == 0


@needs_opengl
def test_panels_of_the_geodesic_picture():
    """Panels come in the requested order and width; an unknown name raises."""
    result = geodesic_result()
    image = geodesic_picture(result, look=Look(width=300), panels=["gradient", "distance"]).astype(int)
    assert image.shape[1] == 600
    np.testing.assert_array_equal(image[:, 300:], geodesic_picture(result, look=Look(width=300), panels=["distance"]))
    brightness = image[40:300, :300].sum(axis=2)
    top, bottom = brightness[60:100, 130:170], brightness[200:240, 130:170]
    assert np.median(top) > np.median(bottom) + 150
    assert count(image[40:300, :300], "#14171c", 40) > 500
    with pytest.raises(FieldError, match="no panel 'flux'"):
        geodesic_picture(result, panels=["flux"])


@needs_opengl
def test_length_of_faint_gradients():
    """Gradients whose squared length underflows are colored by their length."""
    result = geodesic_result()
    faint = [Field(f.name, f.location, f.values * (1e-200 if f.name == "heat_gradient" else 1)) for f in result.fields]
    one, other = (
        geodesic_picture(r, look=Look(width=300), panels=["gradient"]).astype(int)[40:300]
        for r in (result, Result(BALL, faint, result.report, result.sources))
    )
    assert np.mean(np.abs(one - other).max(axis=2) > 8) < 1e-3


@needs_opengl
def test_same_bytes_twice():
    """The same picture has the same bytes."""
    first, second = (geodesic_picture(geodesic_result(), size=(900, 360)) for _ in range(2))
    assert first.tobytes() == second.tobytes()


@needs_opengl
@pytest.mark.parametrize(("scale", "shift"), [(1e-6, 0.0), (1e6, 0.0), (1.0, 1e4)])
def test_independent_of_scale_and_place(scale, shift):
    """Pictures do not depend on scale and position."""
    stretched = BALL.vertices * [1.0, 1.4, 0.7]
    panel = Panel("title", Surface(HEIGHT, isolines=8), [Arrows(geodesic_result()["direction"])], [Marker(5, "five")])
    one, other = (
        picture(panel, mesh=TriangleMesh(points, BALL.faces)) for points in (stretched, stretched * scale + shift)
    )
    assert np.mean(np.abs(one - other).max(axis=2) > 8) < 1e-3


@needs_opengl
def test_helmholtz_picture():
    """A part that is zero has no arrows."""
    mesh = primitives.torus(30, 14)
    around = np.cross([0.0, 0.0, 1.0], mesh.face_centers)
    zero = np.zeros_like(around)
    fields = {"field": around, "curl_free": zero, "coexact": zero, "harmonic": around}
    result = Result(
        mesh,
        [Field(name, "face", values) for name, values in fields.items()]
        + [Field(name, "vertex", mesh.vertices[:, 0]) for name in ("potential", "stream_function")],
    )
    image = helmholtz_picture(result, size=(600, 600))
    panels = [image[:300, :300], image[:300, 300:], image[300:, :300], image[300:, 300:]]
    # Below the title, above bar and key.
    ink = [count(panel[40:225], "#14171c") for panel in panels]
    assert min(ink[0], ink[3]) > 50
    assert max(ink[1:3]) < 5


@needs_opengl
def test_frames_of_a_film_match_single_pictures():
    """Frames of one window equal single pictures."""
    frames = [
        [Panel("up", Surface(HEIGHT), [Arrows(geodesic_result()["direction"])], [Marker(3, "three")])],
        [Panel("down", Surface(-HEIGHT, isolines=4))],
        [Panel("up", Surface(HEIGHT))],
    ]
    view = choose_view(BALL)
    with Drawing(BALL, frames[0], SIZE, view=view) as drawing:
        film = [drawing(panels) for panels in frames]
    for panels, image in zip(frames, film, strict=True):
        np.testing.assert_array_equal(image, draw(BALL, panels, SIZE, view=view))


@needs_opengl
@pytest.mark.parametrize("mesh", [BALL, primitives.grid(20, 4)], ids=["ball", "wide"])
def test_width_of_panels(mesh):
    """Panels of half the width have half the height."""
    large, small = (draw(mesh, [Panel(surface=Surface(bar=False))] * 2, look=Look(width=width)) for width in (600, 300))
    assert (large.shape[0] / 2, large.shape[1] / 2) == pytest.approx(small.shape[:2], abs=1)


@needs_opengl
def test_grid_of_panels():
    """Panels fill a grid from the left, with white at the end."""
    image = draw(BALL, [Panel(f"{k}") for k in range(5)], columns=3)
    assert image.shape[1] == 1800
    height = image.shape[0] // 2
    assert (image[height:, 1200:] == 255).all()
    assert (image[height:, 600:1200] != 255).any()


@needs_opengl
@pytest.mark.parametrize(
    "mesh",
    [
        TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
        primitives.strip(300),
        primitives.moebius_band(30, 4),
        TriangleMesh([*BALL.vertices, [1e9, 1e9, 1e9]], BALL.faces),
        TriangleMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1, 3]]),
    ],
    ids=["one triangle", "strip", "one-sided", "stray vertex", "face without area"],
)
def test_odd_meshes_can_be_drawn(mesh):
    """Unusual meshes are drawn and visible, with constant values too."""
    image = draw(mesh, [Panel("odd", Surface(np.ones(mesh.n_vertices), isolines=3))], (400, 300)).astype(int)
    assert (np.ptp(image[40:240], axis=2) > 30).sum() > 300


@needs_opengl
def test_stage_is_supersampled():
    """The stage has more samples than the picture has pixels."""
    with Stage(BALL, (120, 80)) as stage:
        assert stage.photograph(Surface(HEIGHT)).shape == (80 * SUPERSAMPLING, 120 * SUPERSAMPLING, 3)
