"""Films of flows: all frames have the same size, view, color limits and arrow scale."""

import numpy as np
import pytest
from scipy import ndimage
from scipy.spatial.transform import Rotation

from geomhw.mesh.primitives import icosphere
from geomhw.options import PANEL_WIDTH
from geomhw.render import flow_pictures, panels
from geomhw.render.canvas import Text
from geomhw.render.flow_pictures import ARROW_COLOR, contact_sheet, even_times, flow_film
from geomhw.render.glyphs import comets
from geomhw.render.look import Look
from geomhw.render.view import choose_view
from geomhw.results import Cloud, Field, Result
from support.pictures import count, needs_opengl

BALL = icosphere(2)
SPIN = np.cross([0.0, 1.0, 0.0], BALL.face_centers)
REST = np.zeros_like(SPIN)
MAGENTA = "#ff00ff"
#: How far the sphere's faces are turned to the viewer, and the vertex nearest to the viewer.
TOWARD = BALL.face_normals @ choose_view(BALL).axes[2]
TOWARD_VERTEX = int((BALL.vertices @ choose_view(BALL).axes[2]).argmax())

Pictures = list[np.ndarray]


def moment(
    color: np.ndarray | float,
    velocity: np.ndarray = REST,
    vorticity: float | np.ndarray | None = None,
    time: float = 0.0,
) -> Result:
    """Return a frame of a flow."""
    n = BALL.n_vertices
    fields = [
        Field("color", "vertex", np.full(n, color) if np.ndim(color) == 0 else np.asarray(color)),
        Field("velocity", "face", velocity),
        Field("time", "mesh", np.array([time])),
    ]
    if vorticity is not None:
        fields.append(Field("vorticity", "vertex", vorticity * np.ones(n)))
    return Result(BALL, fields)


def film(*moments: Result) -> Pictures:
    """Return the frames of a film."""
    return [picture.astype(int) for picture in flow_film(moments)]


def middle(picture: np.ndarray, panel: int = 0) -> np.ndarray:
    """Return the color in the middle of the sphere in a panel."""
    row = picture.shape[0] // 2 - 20
    return picture[row - 3 : row + 4, PANEL_WIDTH * panel + 297 : PANEL_WIDTH * panel + 304].mean(axis=(0, 1))


@needs_opengl
def test_rounding_is_drawn_as_no_vorticity() -> None:
    """Vorticity at rounding level is drawn as zero."""
    x = BALL.vertices[:, 0]
    rounding, none, real = (film(moment(1.0, SPIN, w))[0] for w in (1e-13 * x, 1e-30 * x, x + 2))
    np.testing.assert_allclose(middle(rounding, 1), middle(none, 1), atol=2)
    assert np.abs(middle(real, 1) - middle(none, 1)).max() > 50


@needs_opengl
def test_limits_hold_over_the_film() -> None:
    """Equal values have equal colors in all frames."""
    low_high = np.linspace(0, 10, BALL.n_vertices)
    pictures = film(moment(2.0), moment(low_high), moment(8.0), moment(2.0))
    np.testing.assert_array_equal(pictures[0], pictures[3])
    assert np.abs(middle(pictures[0]) - middle(pictures[2])).max() > 50
    # In films of their own, both are in the middle of the color map.
    alone = [film(moment(value))[0] for value in (2.0, 8.0)]
    np.testing.assert_array_equal(middle(alone[0]), middle(alone[1]))


@needs_opengl
def test_one_size() -> None:
    """All frames have one size: one panel, or two where there is vorticity, or speed without vorticity."""
    plain = film(moment(BALL.vertices[:, 0], SPIN), moment(BALL.vertices[:, 0], 2 * SPIN))
    swirling = film(moment(0.5, SPIN, 0.0), moment(0.5, SPIN, BALL.vertices[:, 1]))
    still = film(moment(0.5, SPIN, 0.0), moment(0.6, SPIN, 0.0))
    rest = film(moment(0.5, REST, 0.0))
    noise = 1e-13 * BALL.vertices[:, 1]
    rounding = film(moment(0.5, 1e-14 * SPIN, noise), moment(0.5, 1e-14 * SPIN, noise, time=1.0))
    for pictures, count_ in ((plain, 1), (swirling, 2), (still, 2), (rest, 1), (rounding, 1)):
        assert len({picture.shape for picture in pictures}) == 1
        assert pictures[0].shape[1:] == (count_ * PANEL_WIDTH, 3)


@needs_opengl
def test_vorticity_panel() -> None:
    """Red is counterclockwise, blue clockwise; limits are those of the film."""
    pictures = film(*(moment(0.5, REST, w) for w in (1.0, -1.0, 0.2)))
    strong, opposite, weak = (middle(picture, 1) for picture in pictures)
    assert strong[0] > strong[2] + 40
    assert opposite[2] > opposite[0] + 40
    assert 0 < (weak[0] - weak[2]) / weak[0] < (strong[0] - strong[2]) / strong[0] / 2


@needs_opengl
def test_arrows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Arrows have the scale of the film: none at rest, shorter ones for slower flow."""
    monkeypatch.setattr(flow_pictures, "ARROW_COLOR", MAGENTA)
    rest, slow, fast = (count(picture, MAGENTA) for picture in film(*(moment(0.5, k * SPIN) for k in (0, 1, 3))))
    assert rest < 400  # the key under the panel
    assert fast > slow > rest
    assert fast - rest > 2 * (slow - rest)


@needs_opengl
def test_a_flow_that_fades(monkeypatch: pytest.MonkeyPatch) -> None:
    """Slow frames do not change the scale of a fast one."""
    monkeypatch.setattr(flow_pictures, "ARROW_COLOR", MAGENTA)
    alone = film(moment(0.5, SPIN))[0]
    fading = film(moment(0.5, SPIN), *[moment(0.5, 1e-3 * SPIN)] * 9)
    np.testing.assert_array_equal(fading[0], alone)
    assert count(fading[1], MAGENTA) < 0.1 * count(alone, MAGENTA)


@needs_opengl
def test_the_view_does_not_turn_with_rounding() -> None:
    """The view does not depend on the rounding of the velocity."""
    rounded = [SPIN * (1 + 4e-16 * np.random.default_rng(seed).integers(-2, 3, SPIN.shape)) for seed in range(5)]
    first, *others = (film(moment(0.5, velocity))[0] for velocity in rounded)
    for picture in others:
        np.testing.assert_array_equal(picture, first)


@needs_opengl
@pytest.mark.usefixtures("_same_view")
def test_one_fast_face(monkeypatch: pytest.MonkeyPatch) -> None:
    """The arrow of one fast face has a bounded length."""
    monkeypatch.setattr(flow_pictures, "ARROW_COLOR", MAGENTA)
    front = int(TOWARD.argmax())
    even, fast, faster = (np.array(SPIN) for _ in range(3))
    fast[front] *= 50
    faster[front] *= 5000
    ink = [count(film(moment(0.5, velocity))[0], MAGENTA) for velocity in (even, fast, faster)]
    assert ink[1] > ink[0] + 100
    assert ink[1] == ink[2] < 1.5 * ink[0]


@needs_opengl
@pytest.mark.usefixtures("_same_view")
def test_values_that_were_never_there() -> None:
    """A value beyond the initial range changes the picture only where it is."""
    middling = np.full(BALL.n_vertices, 0.2)
    wrong = middling.copy()
    wrong[TOWARD_VERTEX] = -50.0
    right, beside = (film(moment(BALL.vertices[:, 0]), moment(color))[1] for color in (middling, wrong))
    changed = np.abs(right - beside).max(axis=2)
    assert 1000 < (changed > 30).sum() < 0.05 * changed.size
    assert (changed > 0).sum() < 0.07 * changed.size


# -- streaks -----------------------------------------------------------------------------------------------------

WHITE = "#ffffff"


def cloud(faces: np.ndarray, turn: float = 0.0) -> Cloud:
    """Return tracers at face centers that have turned about y by an angle since time 0."""
    x, times = BALL.face_centers[faces], np.linspace(0, 0.95, 20)
    back = [Rotation.from_rotvec([0, -turn * (1 - t), 0]).apply(x) - x for t in times]
    fields = [
        Field("face", "vertex", faces),
        Field("past", "vertex", np.stack(back, axis=1).reshape(len(x), -1).astype(np.float32)),
        Field("past_times", "mesh", times),
        Field("time", "mesh", np.array([1.0])),
    ]
    return Cloud(x, fields)


def sphere_of(picture: np.ndarray) -> np.ndarray:
    """Return the pixels of the sphere, (1, k, 3)."""
    row, column = np.indices(picture.shape[:2])
    return np.asarray(picture[(row - 362) ** 2 + (column - 300) ** 2 < 277**2][None])


def traced(faces: np.ndarray, turn: float = 0.0, speed: float = 0.0) -> np.ndarray:
    """Return a frame with these tracers in a flow of a speed."""
    (picture,) = flow_film([moment(BALL.vertices[:, 0], speed * SPIN)], [cloud(faces, turn)])
    return picture


def white(faces: np.ndarray, turn: float = 0.0, speed: float = 0.0) -> int:
    """Return the number of white pixels on the sphere."""
    return count(sphere_of(traced(faces, turn, speed)), WHITE)


@pytest.fixture
def _same_view(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fix the view to that of the sphere."""
    monkeypatch.setattr(panels, "choose_view", lambda mesh, *_: choose_view(mesh))


@needs_opengl
@pytest.mark.usefixtures("_same_view")
def test_heads_of_streaks() -> None:
    """Each particle in front has a head, those behind have none."""
    front, behind, rim = (np.flatnonzero(where) for where in (TOWARD > 0.9, TOWARD < -0.2, abs(TOWARD - 0.08) < 0.08))
    assert min(len(front), len(behind), len(rim)) > 5
    assert white(behind) == 0
    np.testing.assert_array_equal(traced(rim), traced(behind))
    one = white(front[:1])
    assert one >= 4
    assert white(front) == pytest.approx(len(front) * one, rel=0.3)


@needs_opengl
@pytest.mark.usefixtures("_same_view")
def test_tails_of_streaks() -> None:
    """Moving particles have tails, longer for faster ones, of the same time in all frames."""
    front = np.flatnonzero(TOWARD > 0.9)
    rest, slow, fast = (white(front, turn, speed=0.5) for turn in (0.0, 0.1, 0.3))
    assert fast > slow > rest
    # In a film of faster flow a streak spans less time.
    assert white(front, 0.3, speed=20.0) < (fast + rest) / 2


@needs_opengl
@pytest.mark.usefixtures("_same_view")
def test_streaks_have_a_dark_line_round_them() -> None:
    """On white dye, streaks are visible by a dark outline."""
    front = np.flatnonzero(TOWARD > 0.9)
    pale = [Field("color", "vertex", np.ones((BALL.n_vertices, 3)))]
    frame = Result(BALL, pale + [field for field in moment(0.0).fields if field.name != "color"])
    (seen,), (hidden,) = (flow_film([frame], [cloud(faces)]) for faces in (front, np.flatnonzero(TOWARD < -0.5)))
    darker = hidden.astype(int).max(axis=2) - seen.max(axis=2) > 40
    assert 5 * len(front) < darker.sum() < 60 * len(front)


def test_comets() -> None:
    """On a straight path a tail has the expected width, area and density, and ends in a disc."""
    paths = np.stack([np.linspace(0, 4, 5), np.full(5, 2.0), np.zeros(5)], axis=1)[:, None]
    points, triangles, density = comets(paths, np.array([0.5]))
    left, right = points[:10].reshape(5, 2, 3).transpose(1, 0, 2)
    np.testing.assert_allclose(right[:, 1] - left[:, 1], 2 * 0.5 * np.linspace(0, 1, 5), atol=1e-15)
    np.testing.assert_allclose(left[:, 0], paths[:, 0, 0])
    np.testing.assert_allclose(np.linalg.norm(points[10:] - paths[-1, 0], axis=1), 0.5)
    np.testing.assert_allclose(density[:10], np.repeat(np.linspace(0, 1, 5), 2))
    corners = points[triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    disc = len(points[10:]) / 2 * np.sin(2 * np.pi / len(points[10:])) * 0.25
    assert areas.sum() == pytest.approx(4 * 1.0 / 2 + disc)


@pytest.mark.parametrize("places", [1, 2, 5])
def test_comets_at_rest(places: int) -> None:
    """A particle at rest is a disc, with finite coordinates."""
    points, triangles, density = comets(np.ones((places, 3, 3)), np.full(3, 0.1))
    assert np.isfinite(points).all()
    assert np.isfinite(density).all()
    assert triangles.max() == len(points) - 1


@needs_opengl
def test_colors_are_drawn_as_they_are() -> None:
    """RGB colors are drawn unchanged and clipped to [0, 1]."""
    n = BALL.n_vertices
    red, green, over = ([1, 0, 0], [0, 1, 0], [1.4, -0.3, 0])
    pictures = film(*(moment(np.tile(rgb, (n, 1)).astype(float)) for rgb in (red, green, over)))
    assert middle(pictures[0])[0] > 150 > 60 > middle(pictures[0])[1:].max()
    assert middle(pictures[1])[1] > 150 > 60 > middle(pictures[1])[[0, 2]].max()
    np.testing.assert_array_equal(pictures[0], pictures[2])


@needs_opengl
def test_bytes_repeat() -> None:
    """The same film is pixel-identical."""
    moments = [moment(k * BALL.vertices[:, 0], SPIN, k * BALL.vertices[:, 1]) for k in (1, 2)]
    for one, other in zip(film(*moments), film(*moments), strict=True):
        np.testing.assert_array_equal(one, other)


def test_arrows_are_dark() -> None:
    """The arrow color is dark."""
    assert int(ARROW_COLOR[1:], 16) < 0x202020


@needs_opengl
@pytest.mark.parametrize(("frames", "most", "drawn"), [(1, 12, 1), (2, 12, 2), (7, 12, 7), (30, 12, 12), (5, 3, 3)])
def test_contact_sheet(frames: int, most: int, drawn: int) -> None:
    """A contact sheet has a panel for each chosen frame, and is about square."""
    sheet = contact_sheet(
        [moment(BALL.vertices[:, 0], SPIN, time=k) for k in range(frames)], look=Look(width=240), most=most
    )
    ball = ndimage.label(ndimage.binary_erosion((sheet.min(axis=2) < 250), iterations=20))[1]
    assert ball == drawn
    assert drawn < 3 or 0.4 < sheet.shape[0] / sheet.shape[1] < 2.5


@needs_opengl
def test_contact_sheet_has_one_bar_for_each_quantity() -> None:
    """The color bars of a sheet are below all panels, and there is one for the color and one for the vorticity."""
    frames = [moment(BALL.vertices[:, 0], SPIN, BALL.vertices[:, 1], k) for k in range(4)]
    look = Look(width=480)
    sheet = np.asarray(contact_sheet(frames, look=look))
    texts = [item.text for item in contact_sheet(frames, look=look).canvas.items if isinstance(item, Text)]
    assert [texts.count(label) for label in ("color", "vorticity [1/time]")] == [1, 1]
    for k in range(4):
        assert [texts.count(f"{title}, t = {k}") for title in ("color and velocity", "vorticity")] == [1, 1]
    assert min(item.size for item in contact_sheet(frames, look=look).canvas.items if isinstance(item, Text)) >= 10
    assert (sheet[-80:] < 250).any()


def test_even_times() -> None:
    """Frames of a sheet are those nearest to an even division of the time, the first and the last among them."""
    assert even_times([0.0, 1, 2, 3], 12) == [0, 1, 2, 3]
    assert even_times([0.0, 0.1, 0.2, 0.3, 1.0, 2.0], 3) == [0, 4, 5]
    assert even_times([0.0], 12) == [0]
