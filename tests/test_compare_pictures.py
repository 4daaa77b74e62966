"""Comparing pictures: what an eye would pass over passes, what it would miss is found, and shown."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageDraw
from test_commands import run
from test_render import needs_opengl

from geomhw.compare import compare_files
from geomhw.compare.colors import delta_e, lab, over_white
from geomhw.compare.pictures import NOTICEABLE, Difference, compare_pictures, difference_picture
from geomhw.io import read_png, write_png
from geomhw.mesh.primitives import icosphere
from geomhw.render import colors, glyphs, panels, scene
from geomhw.render.annotate import font
from geomhw.render.layers import Arrows, Panel, Surface
from geomhw.render.panels import draw

SIZE = (240, 160)
ARROWS = 12


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Each test works in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def drawing(sampling: int = 4, without: int | None = None, text: str = "distance −0.05", shift: float = 0.0):
    """A shaded disc with arrows on it, thin lines and a label, (h, w, 4), at so many samples squared in each pixel."""
    width, height = SIZE
    offsets = (np.arange(sampling) + 0.5) / sampling
    x = (np.arange(width)[:, None] + offsets).ravel()[None, :]
    y = (np.arange(height)[:, None] + offsets).ravel()[:, None]
    shade = 80 + 100 * x / width + 0 * y
    samples = np.stack([shade, 0.6 * shade, 220 - shade], axis=2)
    samples[np.hypot(x - 80, y - 70) > 60] = 255
    for k in range(ARROWS):
        if k != without:
            turn = np.array([[np.cos(k), np.sin(k)], [-np.sin(k), np.cos(k)]])
            ends = np.array([[-6, 0], [6, 0], [2, 2.2], [2, -2.2]]) @ turn + [
                50 + 20 * (k % 4) + shift,
                45 + 24 * (k // 4),
            ]
            for tail in (0, 2, 3):
                samples[_stroke(x, y, ends[tail], ends[1], 0.7)] = (20, 23, 28)
    for k in range(4):
        samples[_stroke(x, y, (160 + shift, 20 + 9 * k), (230 + shift, 14 + 13 * k), 0.5)] = 0
    mean = samples.reshape(height, sampling, width, sampling, 3).mean(axis=(1, 3))
    image = Image.fromarray(np.rint(mean).astype(np.uint8))
    ImageDraw.Draw(image).text((150, 135), text, fill="#1b1f24", font=font(11))
    return np.asarray(image.convert("RGBA"))


def _stroke(x, y, begin, end, radius: float):
    """Samples within a radius of a segment."""
    (a, b), (c, d) = begin, end
    along = np.clip(((x - a) * (c - a) + (y - b) * (d - b)) / ((c - a) ** 2 + (d - b) ** 2), 0, 1)
    return np.hypot(x - a - along * (c - a), y - b - along * (d - b)) < radius


PLAIN = drawing()


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
    """Published coordinates of the primaries and of the gray in the middle."""
    np.testing.assert_allclose(lab(np.uint8([rgb]))[0], expected, atol=0.02)


def test_opacity():
    """What is clear looks white; that it is clear counts all the same."""
    clear, white, half = np.uint8([[[9, 9, 9, 0]]]), np.uint8([[[255, 255, 255, 255]]]), np.uint8([[[0, 0, 0, 128]]])
    np.testing.assert_array_equal(over_white(clear)[0, 0], [255, 255, 255, 0])
    np.testing.assert_array_equal(over_white(half)[0, 0], [127, 127, 127, 128])
    assert delta_e(over_white(clear)[0], white[0]) == pytest.approx(100)
    patch = np.repeat(np.repeat(white, 9, 0), 9, 1)
    hole = patch.copy()
    hole[4:7, 4:7, 3] = 0
    assert not compare_pictures(patch, hole).same


# -- what passes -------------------------------------------------------------------------------------------------


def test_equal_pictures():
    finding = compare_pictures(PLAIN, PLAIN)
    assert finding.same
    assert finding.size == SIZE
    assert finding.details == {}


@pytest.mark.parametrize("sampling", [2, 3, 5, 6])
def test_other_antialiasing_passes(sampling):
    """Hundreds of pixels differ by many levels, and nobody would see it."""
    finding = compare_pictures(PLAIN, drawing(sampling))
    assert finding.details["unequal_pixels"] > 300
    assert finding.details["largest_level_difference"] > 20
    assert finding.same


@pytest.mark.parametrize("shift", [0.125, 0.25])
def test_small_moves_pass(shift):
    """Arrows and hairlines that move by up to a quarter of a pixel."""
    finding = compare_pictures(PLAIN, drawing(shift=shift))
    assert finding.details["unequal_pixels"] > 100
    assert finding.same


def test_noise_passes():
    """One level up or down in every channel of every pixel, and what JPEG leaves at its best."""
    noise = np.random.default_rng(0).integers(-1, 2, PLAIN.shape)
    noise[..., 3] = 0
    finding = compare_pictures(PLAIN, np.clip(PLAIN.astype(int) + noise, 0, 255).astype(np.uint8))
    assert finding.same
    assert finding.details["largest_level_difference"] == 1
    assert finding.details["noticeable_pixels"] == 0
    Image.fromarray(PLAIN[..., :3]).save("a.jpg", quality=98, subsampling=0)
    assert compare_pictures(PLAIN, np.asarray(Image.open("a.jpg").convert("RGBA"))).same


# -- what is found -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("k", range(ARROWS))
def test_a_lost_arrow_is_found(k):
    """Whichever it is, and whichever of the pictures lacks it; the spot lies on its place."""
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
    """Lost, without its sign, without its point, of another number, with a hyphen: at its place."""
    dark = np.uint8([255, 255, 255, 0]) if paper == "dark" else np.uint8(0)
    finding = compare_pictures(PLAIN ^ dark, drawing(text=text) ^ dark)
    assert not finding.same
    for spot in finding.details["heaviest_spots"]:
        assert min(spot["y"]) >= 130
        assert min(spot["x"]) >= 148


def test_half_a_pixel():
    """A black line that moves by a pixel counts, in both places, by what it goes beyond the gray half way."""
    pair = np.full((2, 9, 9, 4), 255, np.uint8)
    pair[0, :, 3, :3] = pair[1, :, 4, :3] = 0
    gray, black = np.uint8([[127, 127, 127, 255]]), np.uint8([[0, 0, 0, 255]])
    expected = np.zeros((9, 9))
    expected[:, 3:5] = delta_e(black, gray)[0]  # more than from white to gray
    np.testing.assert_array_equal(Difference(*pair).delta_e, expected)


def test_corners_connect():
    """A hairline that runs diagonally is one spot."""
    white = np.full((40, 60, 4), 255, np.uint8)
    crossed = white.copy()
    crossed[np.arange(10, 25), np.arange(10, 25), :3] = 200
    finding = compare_pictures(white, crossed)
    assert (finding.beyond, finding.details["spots"]) == (1, 1)


@pytest.mark.parametrize("shift", [1.0, 3.0])
def test_moves_are_found(shift):
    assert not compare_pictures(PLAIN, drawing(shift=shift)).same


def test_other_colors_are_found():
    """A surface that is noticeably darker, though no pixel is by much."""
    darker = PLAIN.copy()
    darker[10:130, 20:140, :3] = np.clip(darker[10:130, 20:140, :3].astype(int) - 12, 0, 255)
    finding = compare_pictures(PLAIN, darker)
    assert not finding.same
    assert finding.details["largest_level_difference"] == 12
    assert NOTICEABLE < finding.details["largest_delta_e"] < 10


def test_weight_is_the_sum_over_the_spot():
    """Gray on white: area times ΔE*ab; the limit is exact, and 0 lets nothing pass that is noticed."""
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


# -- the command and its picture ---------------------------------------------------------------------------------


def save(name: str, image) -> None:
    Image.fromarray(image).save(name)


def test_command():
    """Exit codes, one line that says how many, by how much and where; the same in the report."""
    save("a.png", PLAIN)
    save("b.png", drawing(without=5))
    assert run("compare", "a.png", "a.png").exit_code == 0
    answer = run("compare", "a.png", "b.png")
    assert answer.exit_code == 1
    for words in ("different", "240 x 160", "of 38400 pixels unequal", "255 levels", "(200 passes), at x 6"):
        assert words in answer.stdout
    report = json.loads(run("compare", "a.png", "b.png", "--json", "--diff", "d.png").stdout)
    assert report["files"] == ["d.png"]
    (found,) = report["findings"]
    assert found["details"]["unequal_pixels"] >= found["details"]["noticeable_pixels"] > 20
    assert found["tolerance"] == 200
    assert run("compare", "a.png", "b.png", "--spot", "5000").exit_code == 0
    assert run("compare", "a.png", "b.png", "--spot", "-1").exit_code == 2


def test_difference_picture():
    """Equal pixels pale gray, unequal ones blue, noticeable ones red, an orange frame round the arrow and no other."""
    save("a.png", PLAIN)
    other = drawing(without=5).copy()
    other[5, 5, :3] = 254
    save("b.png", other)
    assert run("compare", "a.png", "b.png", "--diff", "d.png", "-q").exit_code == 1
    shown = read_png("d.png")[..., :3]
    equal = (other == PLAIN).all(axis=2)
    is_orange = (shown == (240, 130, 0)).all(axis=2)
    pale = shown[equal & ~is_orange]
    assert (pale == pale[:, :1]).all()
    assert pale.min() > 160
    assert tuple(shown[5, 5]) == (175, 205, 240)
    red = (shown == (200, 0, 60)).all(axis=2)
    assert red.sum() == compare_files("a.png", "b.png").findings[0].details["noticeable_pixels"]
    rows, columns = np.nonzero(is_orange)
    (spot,) = compare_files("a.png", "b.png").findings[0].details["heaviest_spots"][:1]
    assert (columns.min(), columns.max()) == (spot["x"][0] - 6, spot["x"][1] + 6)
    assert (rows.min(), rows.max()) == (spot["y"][0] - 6, spot["y"][1] + 6)
    before = Path("d.png").read_bytes()
    run("compare", "a.png", "b.png", "--diff", "d.png")
    assert Path("d.png").read_bytes() == before


def test_other_sizes():
    """One line; the picture is as large as both together, orange where one of them has nothing."""
    save("a.png", PLAIN)
    save("b.png", PLAIN[:100, :200])
    answer = run("compare", "a.png", "b.png", "--diff", "d.png")
    assert answer.exit_code == 1
    assert "240 x 160 in A, 200 x 100 in B" in answer.stdout
    shown = read_png("d.png")[..., :3]
    assert shown.shape == (160, 240, 3)
    assert (shown[100:] == (240, 130, 0)).all()
    np.testing.assert_array_equal(shown[:100, :200], difference_picture(PLAIN[:100, :200], PLAIN[:100, :200]))


def test_input_is_kept():
    """The difference is not written over what is compared: trouble, not a difference."""
    save("a.png", PLAIN)
    before = Path("a.png").read_bytes()
    answer = run("compare", "a.png", "a.png", "--diff", "a.png")
    assert (answer.exit_code, "input" in answer.stderr) == (2, True)
    assert run("compare", "a.png", "a.png", "--diff", "d.jpg").exit_code == 2
    assert Path("a.png").read_bytes() == before


@pytest.mark.parametrize("mode", ["1", "L", "LA", "P", "RGB", "RGBA"])
def test_kinds_of_png(mode):
    """Whatever kind of PNG holds the same colors."""
    image = Image.fromarray(np.uint8([[0, 255], [255, 0]] * 4)).convert("RGB")
    image.save("a.png")
    image.convert(mode).save("b.png")
    assert compare_files("a.png", "b.png").findings[0].details == {}


def test_deep_pngs_are_refused():
    """16 bits are not cut down to 8 in silence."""
    Image.fromarray(np.zeros((4, 4), np.uint16)).save("a.png")
    answer = run("compare", "a.png", "a.png")
    assert answer.exit_code == 2
    assert "more than 8 bits" in answer.stderr


@needs_opengl
def test_real_pictures(monkeypatch):
    """Pictures of this program: one with more samples passes, one that lacks an arrow or a digit does not."""
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
