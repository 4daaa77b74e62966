"""Films of flows: one size, one view, one meaning of color and arrow from the first frame to the last."""

import numpy as np
import pytest
from test_render import count, needs_opengl

from geomhw.mesh.primitives import icosphere
from geomhw.render import flow_pictures
from geomhw.render.flow_pictures import ARROW_COLOR, contact_sheet, flow_film
from geomhw.render.panels import PANEL_WIDTH
from geomhw.results import Field, Result

BALL = icosphere(2)
SPIN = np.cross([0.0, 1.0, 0.0], BALL.face_centers)
REST = np.zeros_like(SPIN)
MAGENTA = "#ff00ff"

Pictures = list[np.ndarray]


def moment(
    color: np.ndarray | float, velocity: np.ndarray = REST, vorticity: float | np.ndarray | None = None
) -> Result:
    """A frame of a flow at time 0: the same title on all of them."""
    n = BALL.n_vertices
    fields = [
        Field("color", "vertex", np.full(n, color) if np.ndim(color) == 0 else np.asarray(color)),
        Field("velocity", "face", velocity),
        Field("time", "mesh", np.array([0.0])),
    ]
    if vorticity is not None:
        fields.append(Field("vorticity", "vertex", vorticity * np.ones(n)))
    return Result(BALL, fields)


def film(*moments: Result) -> Pictures:
    """The frames, one after the other."""
    return [picture.astype(int) for picture in flow_film(moments)]


def middle(picture: np.ndarray, panel: int = 0) -> np.ndarray:
    """The color in the middle of the sphere, as it is drawn in a panel."""
    row = picture.shape[0] // 2 - 20
    return picture[row - 3 : row + 4, PANEL_WIDTH * panel + 297 : PANEL_WIDTH * panel + 304].mean(axis=(0, 1))


@needs_opengl
def test_limits_hold_over_the_film() -> None:
    """The same value has the same color in every frame, though other values come and go; another value another."""
    low_high = np.linspace(0, 10, BALL.n_vertices)
    pictures = film(moment(2.0), moment(low_high), moment(8.0), moment(2.0))
    np.testing.assert_array_equal(pictures[0], pictures[3])
    assert np.abs(middle(pictures[0]) - middle(pictures[2])).max() > 50
    # Alone, both would be in the middle of the color map.
    alone = [film(moment(value))[0] for value in (2.0, 8.0)]
    np.testing.assert_array_equal(middle(alone[0]), middle(alone[1]))


@needs_opengl
def test_one_size() -> None:
    """All frames have one size, that of the first, with as many panels: one, or two where there is vorticity."""
    plain = film(moment(BALL.vertices[:, 0], SPIN), moment(BALL.vertices[:, 0], 2 * SPIN))
    swirling = film(moment(0.5, SPIN, 0.0), moment(0.5, SPIN, BALL.vertices[:, 1]))
    still = film(moment(0.5, SPIN, 0.0), moment(0.6, SPIN, 0.0))
    for pictures, panels in ((plain, 1), (swirling, 2), (still, 1)):
        assert len({picture.shape for picture in pictures}) == 1
        assert pictures[0].shape[1:] == (panels * PANEL_WIDTH, 3)


@needs_opengl
def test_vorticity_panel() -> None:
    """Red turns counterclockwise, blue clockwise, with limits of the film, so that a weak one is pale."""
    pictures = film(*(moment(0.5, REST, w) for w in (1.0, -1.0, 0.2)))
    strong, opposite, weak = (middle(picture, 1) for picture in pictures)
    assert strong[0] > strong[2] + 40
    assert opposite[2] > opposite[0] + 40
    assert 0 < (weak[0] - weak[2]) / weak[0] < (strong[0] - strong[2]) / strong[0] / 2


@needs_opengl
def test_arrows(monkeypatch: pytest.MonkeyPatch) -> None:
    """A flow has arrows; rest has none; one a third as fast has smaller ones, by the scale of the film."""
    monkeypatch.setattr(flow_pictures, "ARROW_COLOR", MAGENTA)
    rest, slow, fast = (count(picture, MAGENTA) for picture in film(*(moment(0.5, k * SPIN) for k in (0, 1, 3))))
    assert rest < 200  # the key under the panel
    assert fast > slow > rest
    assert fast - rest > 2 * (slow - rest)


@needs_opengl
def test_colors_are_drawn_as_they_are() -> None:
    """RGB needs no color map and knows no limits: red is red beside any frame; beyond 0..1 it is cut off."""
    n = BALL.n_vertices
    red, green, over = ([1, 0, 0], [0, 1, 0], [1.4, -0.3, 0])
    pictures = film(*(moment(np.tile(rgb, (n, 1)).astype(float)) for rgb in (red, green, over)))
    assert middle(pictures[0])[0] > 150 > 60 > middle(pictures[0])[1:].max()
    assert middle(pictures[1])[1] > 150 > 60 > middle(pictures[1])[[0, 2]].max()
    np.testing.assert_array_equal(pictures[0], pictures[2])


@needs_opengl
def test_bytes_repeat() -> None:
    """The same film twice, pixel by pixel."""
    moments = [moment(k * BALL.vertices[:, 0], SPIN, k * BALL.vertices[:, 1]) for k in (1, 2)]
    for one, other in zip(film(*moments), film(*moments), strict=True):
        np.testing.assert_array_equal(one, other)


def test_arrows_are_dark() -> None:
    """Ink that is seen on every color of the maps."""
    assert int(ARROW_COLOR[1:], 16) < 0x202020


def plain(level: int, size: tuple[int, int] = (40, 60)) -> np.ndarray:
    """One gray."""
    return np.full((*size, 3), level, dtype=np.uint8)


def test_contact_sheet() -> None:
    """From left to right, then down, at half the size; what is left over is white."""
    sheet = contact_sheet([plain(20 * k) for k in range(5)], columns=3)
    assert sheet.shape == (40, 90, 3)
    found = [int(sheet[10 + 20 * row, 15 + 30 * column, 0]) for row in range(2) for column in range(3)]
    assert found == [0, 20, 40, 60, 80, 255]


def test_few_pictures_keep_their_size() -> None:
    """One or two are not made smaller."""
    assert contact_sheet([plain(9)]).shape == (40, 60, 3)
    sheet = contact_sheet([plain(9), plain(7)])
    assert sheet.shape[0] * sheet.shape[1] == 2 * 40 * 60
    assert set(np.unique(sheet)) == {7, 9}


@pytest.mark.parametrize("size", [(100, 100), (100, 200), (100, 50), (101, 77)])
@pytest.mark.parametrize("count_", [3, 4, 7, 12])
def test_a_sheet_is_about_square(count_: int, size: tuple[int, int]) -> None:
    """Of any number of pictures of any shape, none missing, and without an empty row."""
    sheet = contact_sheet([plain(k, size) for k in range(count_)])
    rows, columns = round(2 * sheet.shape[0] / size[0]), round(2 * sheet.shape[1] / size[1])
    assert rows * columns >= count_ > (rows - 1) * columns
    assert 0.4 < sheet.shape[0] / sheet.shape[1] < 2.5
