"""Pictures of transported vectors: arrows, sources, panels, and nothing beyond the panel."""

from itertools import pairwise

import numpy as np
import pytest

from geomhw.mesh.primitives import grid, icosphere
from geomhw.options import PANEL_WIDTH
from geomhw.render import source_marks
from geomhw.render.look import Look
from geomhw.render.scene import Stage
from geomhw.render.vector_pictures import FIELD_COLOR, LENGTH, SOURCE_COLOR, transport_picture
from geomhw.render.view import choose_view, landmarks
from geomhw.results import Result
from geomhw.transport.vector_heat import tangent_at, transport_over_times
from support.pictures import ink, needs_opengl

pytestmark = needs_opengl

BALL = icosphere(3)
FRONT = int((BALL.vertices @ choose_view(BALL).axes[2]).argmax())
TITLE = 40  # rows above the stage


def transported(sources: list[int], times: list[str], lengths: list[float] | None = None) -> Result:
    """Transport vectors at 90° of the frames at vertices of the ball."""
    vectors = [length * tangent_at(BALL, s, 90) for s, length in zip(sources, lengths or [1.0] * 9, strict=False)]
    return transport_over_times(BALL, sources, vectors, times)


@pytest.fixture
def _no_labels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the labels of sources, which have their color."""
    monkeypatch.setattr(source_marks, "MOST_LABELS", 0)


def test_arrows_and_source_are_seen() -> None:
    """Arrows cover the ball, and the source is near the middle."""
    image = transport_picture(transported([FRONT], ["h2"]))
    field, source = ink(image, FIELD_COLOR), ink(image, SOURCE_COLOR)
    rows, columns = np.nonzero(field)
    assert field.sum() > 3000
    assert min(np.ptp(rows), np.ptp(columns)) > 0.75 * PANEL_WIDTH
    assert source.sum() > 300
    middle = np.array(image.shape[:2]) / 2
    assert np.abs(np.mean(np.nonzero(source), axis=1) - middle).max() < 0.15 * PANEL_WIDTH


@pytest.mark.parametrize(
    ("shape", "outward"),
    [
        *(((8, 8), outward) for outward in ((1, 0), (-1, 0), (0, 1), (0, -1))),
        *((shape, outward) for shape in ((20, 8), (8, 20)) for outward in ((1, 0), (0, 1))),
    ],
)
@pytest.mark.usefixtures("_no_labels")
def test_source_arrow_stays_inside(shape: tuple[int, int], outward: tuple[int, int]) -> None:
    """The arrow of a source at the border stays inside the panel."""
    sheet = grid(*shape)
    center = sheet.vertices.mean(axis=0)
    direction = np.array([*outward, 0.0])
    rim = int(((sheet.vertices - center) @ direction - 1e-3 * np.linalg.norm(sheet.vertices - center, axis=1)).argmax())
    middle = int(np.linalg.norm(sheet.vertices - center, axis=1).argmin())
    seen = []
    for source in (rim, middle):
        image = transport_picture(transport_over_times(sheet, [source], [direction], ["h2"]), Look(width=1200))
        large = ink(image, SOURCE_COLOR)
        rows, columns = np.nonzero(large)
        seen.append(large.sum())
        assert rows.min() > TITLE
        assert 3 < columns.min() < columns.max() < image.shape[1] - 4
    assert seen[0] > 0.97 * seen[1]


def test_view_turns_to_the_sources() -> None:
    """The view turns to a source on the far side."""
    behind = int(np.argmin(BALL.vertices @ choose_view(BALL).axes[2] + np.abs(BALL.vertices[:, 1])))
    with Stage(BALL, (200, 200)) as stage:
        assert not stage.visible(BALL.vertices[[behind]])[0]
    image = transport_picture(transported([behind], ["h2"]))
    rows, columns = np.nonzero(ink(image, SOURCE_COLOR))
    with Stage(BALL, (200, 200), choose_view(BALL, landmarks(BALL, [behind]))) as stage:
        assert stage.visible(BALL.vertices[[behind]])[0]
    assert len(rows) > 500
    assert max(np.ptp(rows), np.ptp(columns)) > 0.5 * LENGTH * PANEL_WIDTH


@pytest.mark.usefixtures("_no_labels")
def test_length_at_a_source_is_drawn() -> None:
    """The drawn length of a vector is relative to the largest."""
    beside = int(np.argsort(BALL.vertices @ BALL.vertices[FRONT])[-40])
    equal, longer = (
        ink(transport_picture(transported([FRONT, beside], ["h2"], [1.0, length])), SOURCE_COLOR).sum()
        for length in (1.0, 3.0)
    )
    assert longer < 0.8 * equal


def test_sources_close_together_keep_their_arrows() -> None:
    """Two neighboring sources both have their arrows."""
    neighbor = int(np.argsort(BALL.vertices @ BALL.vertices[FRONT])[-2])
    one = ink(transport_picture(transported([FRONT], ["h2"])), SOURCE_COLOR).sum()
    two = ink(transport_picture(transported([FRONT, neighbor], ["h2"])), SOURCE_COLOR).sum()
    assert two > 1.3 * one


@pytest.mark.parametrize(("count", "columns", "rows"), [(1, 1, 1), (2, 2, 1), (3, 3, 1), (5, 4, 2)])
def test_a_panel_for_each_time(count: int, columns: int, rows: int) -> None:
    """There is one panel per time, at most four in a row, each with its title and field."""
    times = [f"{10**k}*h2" for k in range(count)]
    image = transport_picture(transported([FRONT], times))
    height = image.shape[0] // rows
    assert image.shape[1] == columns * PANEL_WIDTH
    panels = [
        image[row * height : (row + 1) * height, column * PANEL_WIDTH : (column + 1) * PANEL_WIDTH]
        for row, column in (divmod(k, columns) for k in range(count))
    ]
    for panel in panels:
        assert ink(panel, FIELD_COLOR).sum() > 3000
    for one, other in pairwise(panels):
        assert (one[:TITLE] != other[:TITLE]).any()
        assert (one[TITLE:] != other[TITLE:]).any()
