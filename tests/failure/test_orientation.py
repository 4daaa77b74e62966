"""Meshes that are not oriented are refused with the edge and the reason."""

import pytest

from geomhw.errors import MeshError
from support.hostile import hostile


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("moebius", "a flow .*oriented manifold.*one-sided"),
        ("turned_grid", r"edge 0-10 \(88 such edges\) disagree"),
        ("book_3", r"3 faces meet at edge 0-7 \(6 .*edges\); remove"),
        ("doubled", r"3 faces meet at edge 0-42 \(67 .*edges\).*face 320 .*copy.* face 5"),
    ],
)
def test_what_is_not_oriented_is_named(name: str, words: str) -> None:
    """The message has the first edge, the number of edges and the reason."""
    with pytest.raises(MeshError, match=words):
        hostile(name).require_oriented("a flow")
