"""Comparison of pictures: invisible deviations pass, visible ones are found and located."""

import numpy as np
import pytest
from PIL import Image

from geomhw.compare import compare_files
from geomhw.compare.pictures import NOTICEABLE, Difference, compare_pictures, delta_e, lab, over_white
from geomhw.io import write_png
from geomhw.mesh.primitives import icosphere
from geomhw.render import colors, glyphs, panels, scene
from geomhw.render.layers import Arrows, Panel, Surface
from geomhw.render.panels import draw
from support.pictures import ARROWS, PLAIN, SIZE, drawing, needs_opengl

pytestmark = pytest.mark.usefixtures("folder")


# -- colors ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rgb", "expected"),
    [
        ((255, 255, 255), (100, 0, 0)),
        ((0, 0, 0), (0, 0, 0)),
        ((255, 0, 0), (53.24, 80.09, 67.20)),
        ((0, 255, 0), (87.73, -86.18, 83.18)),
        ((0, 0, 255), (32.30, 79.19, -107.86)),
        ((119, 119, 119), (50.03, 0, 0)),
    ],
)
def test_lab(rgb, expected):
    """CIELAB coordinates of the primaries and of middle gray are the published ones."""
    np.testing.assert_allclose(lab(np.uint8([rgb]))[0], expected, atol=0.02)


def test_opacity():
    """Transparent pixels look white, but their opacity is compared."""
    clear, white, half = np.uint8([[[9, 9, 9, 0]]]), np.uint8([[[255, 255, 255, 255]]]), np.uint8([[[0, 0, 0, 128]]])
    np.testing.assert_array_equal(over_white(clear)[0, 0], [255, 255, 255, 0])
    np.testing.assert_array_equal(over_white(half)[0, 0], [127, 127, 127, 128])
    assert delta_e(over_white(clear)[0], white[0]) == pytest.approx(100)
    patch = np.repeat(np.repeat(white, 9, 0), 9, 1)
    hole = patch.copy()
    hole[4:7, 4:7, 3] = 0
    assert not compare_pictures(patch, hole).same


# -- deviations that pass ----------------------------------------------------------------------------------------


def test_equal_pictures():
    """Equal pictures have no deviation."""
    finding = compare_pictures(PLAIN, PLAIN)
    assert finding.same
    assert finding.size == SIZE
    assert finding.details == {}


@pytest.mark.parametrize("sampling", [2, 3, 5, 6])
def test_other_antialiasing_passes(sampling):
    """Other antialiasing passes, although hundreds of pixels differ by many levels."""
    finding = compare_pictures(PLAIN, drawing(sampling))
    assert finding.details["unequal_pixels"] > 300
    assert finding.details["largest_level_difference"] > 20
    assert finding.same


@pytest.mark.parametrize("shift", [0.125, 0.25])
def test_small_moves_pass(shift):
    """Shifts by up to a quarter of a pixel pass."""
    finding = compare_pictures(PLAIN, drawing(shift=shift))
    assert finding.details["unequal_pixels"] > 100
    assert finding.same


def test_noise_passes():
    """Noise of one level in every channel passes, and so does the best JPEG quality."""
    noise = np.random.default_rng(0).integers(-1, 2, PLAIN.shape)
    noise[..., 3] = 0
    finding = compare_pictures(PLAIN, np.clip(PLAIN.astype(int) + noise, 0, 255).astype(np.uint8))
    assert finding.same
    assert finding.details["largest_level_difference"] == 1
    assert finding.details["noticeable_pixels"] == 0
    Image.fromarray(PLAIN[..., :3]).save("a.jpg", quality=98, subsampling=0)
    assert compare_pictures(PLAIN, np.asarray(Image.open("a.jpg").convert("RGBA"))).same


# -- deviations that are found -----------------------------------------------------------------------------------


@pytest.mark.parametrize("k", range(ARROWS))
def test_a_lost_arrow_is_found(k):
    """Each missing arrow is found at its place, in either picture."""
    without = drawing(without=k)
    for pair in ((PLAIN, without), (without, PLAIN)):
        finding = compare_pictures(*pair)
        assert not finding.same
        assert finding.beyond == 1
        x, y = finding.index
        assert np.hypot(x - 50 - 20 * (k % 4), y - 45 - 24 * (k // 4)) < 7


@pytest.mark.parametrize("text", ["", *(f"distance {end}" for end in ("0.05", "−005", "−0.06", "−0.08", "-0.05"))])
@pytest.mark.parametrize("paper", ["bright", "dark"])
def test_a_changed_label_is_found(text, paper):
    """A missing or changed label is found at its place: sign, point, digit or hyphen."""
    dark = np.uint8([255, 255, 255, 0]) if paper == "dark" else np.uint8(0)
    finding = compare_pictures(PLAIN ^ dark, drawing(text=text) ^ dark)
    assert not finding.same
    for spot in finding.details["heaviest_spots"]:
        assert min(spot["y"]) >= 130
        assert min(spot["x"]) >= 148


def test_half_a_pixel():
    """A black line moved by one pixel counts by its difference to the gray of half a pixel."""
    pair = np.full((2, 9, 9, 4), 255, np.uint8)
    pair[0, :, 3, :3] = pair[1, :, 4, :3] = 0
    gray, black = np.uint8([[127, 127, 127, 255]]), np.uint8([[0, 0, 0, 255]])
    expected = np.zeros((9, 9))
    expected[:, 3:5] = delta_e(black, gray)[0]  # more than from white to gray
    np.testing.assert_array_equal(Difference(*pair).delta_e, expected)


def test_corners_connect():
    """Diagonally connected pixels form one spot."""
    white = np.full((40, 60, 4), 255, np.uint8)
    crossed = white.copy()
    crossed[np.arange(10, 25), np.arange(10, 25), :3] = 200
    finding = compare_pictures(white, crossed)
    assert (finding.beyond, finding.details["spots"]) == (1, 1)


@pytest.mark.parametrize("shift", [1.0, 3.0])
def test_moves_are_found(shift):
    """Shifts of a pixel and more are found."""
    assert not compare_pictures(PLAIN, drawing(shift=shift)).same


def test_other_colors_are_found():
    """A noticeably darker surface is found, although no pixel differs by much."""
    darker = PLAIN.copy()
    darker[10:130, 20:140, :3] = np.clip(darker[10:130, 20:140, :3].astype(int) - 12, 0, 255)
    finding = compare_pictures(PLAIN, darker)
    assert not finding.same
    assert finding.details["largest_level_difference"] == 12
    assert NOTICEABLE < finding.details["largest_delta_e"] < 10


def test_weight_is_the_sum_over_the_spot():
    """The weight of a spot is the sum of ΔE*ab over its area; the limit is exact."""
    white = np.full((40, 60, 4), 255, np.uint8)
    spotted = white.copy()
    spotted[10:14, 20:25, :3] = 200
    each = delta_e(np.uint8([[200, 200, 200, 255]]), np.uint8([[255, 255, 255, 255]]))[0]
    finding = compare_pictures(white, spotted, heaviest=20 * each * 1.001)
    assert finding.same
    assert finding.absolute == pytest.approx(20 * each)
    assert not compare_pictures(white, spotted, heaviest=20 * each * 0.999).same
    assert finding.details["heaviest_spots"] == [
        {"x": (20, 24), "y": (10, 13), "weight": pytest.approx(20 * each), "pixels": 20, "delta_e": pytest.approx(each)}
    ]
    spotted[30, 50, :3] = 0
    finding = compare_pictures(white, spotted, heaviest=0)
    assert finding.beyond == 2
    assert [spot["pixels"] for spot in finding.details["heaviest_spots"]] == [20, 1]


@pytest.mark.parametrize("mode", ["1", "L", "LA", "P", "RGB", "RGBA"])
def test_kinds_of_png(mode):
    """PNG files of every mode with the same colors are equal."""
    image = Image.fromarray(np.uint8([[0, 255], [255, 0]] * 4)).convert("RGB")
    image.save("a.png")
    image.convert(mode).save("b.png")
    assert compare_files("a.png", "b.png").findings[0].details == {}


@needs_opengl
def test_real_pictures(monkeypatch):
    """Pictures of this program: more samples pass, a missing arrow or a changed digit is found."""
    ball = icosphere(3)
    around = np.cross([0.0, 1.0, 0.0], ball.face_centers)

    def drawn(name: str) -> None:
        colored = Surface(ball.vertices[:, 1], isolines=8, label="height")
        write_png(name, draw(ball, [Panel("height", colored, [Arrows(around, spacing=0.06)])], (480, 400)))

    drawn("plain.png")
    with monkeypatch.context() as patch:
        patch.setattr(scene, "SUPERSAMPLING", 3)
        patch.setattr(panels, "SUPERSAMPLING", 3)
        drawn("finer.png")
    with monkeypatch.context() as patch:
        spread = glyphs.spread
        patch.setattr(glyphs, "spread", lambda *where: np.delete(spread(*where), 20))
        drawn("arrow.png")
    with monkeypatch.context() as patch:
        ticks = colors.tick_labels
        patch.setattr(colors, "tick_labels", lambda values: ([t.replace("5", "6") for t in ticks(values)[0]], ""))
        drawn("digit.png")
    finer = compare_files("plain.png", "finer.png").findings[0]
    assert finer.details["unequal_pixels"] > 5_000
    assert finer.same
    for name, spots in (("arrow.png", 1), ("digit.png", 2)):
        found = compare_files("plain.png", name).findings[0]
        assert (found.same, found.beyond) == (False, spots)
