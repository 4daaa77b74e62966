"""Pictures of direction fields and Killing fields: crosses, singularities by sign, panels."""

import numpy as np

from geomhw.directions import DirectionFields, trivial_connection
from geomhw.mesh.primitives import icosphere, torus
from geomhw.options import PANEL_WIDTH
from geomhw.render import direction_picture, killing_picture
from geomhw.render.direction_picture import NEGATIVE, POSITIVE
from geomhw.spectral import killing_fields
from support.pictures import ink, needs_opengl

pytestmark = needs_opengl


def test_directions_and_singularities_are_seen() -> None:
    """Directions cover the mesh; lines on a sphere have positive singularities only, a torus with a pair both."""
    fields = DirectionFields(icosphere(3), 2)
    result = fields.result(fields.smoothest())
    assert all(item["index"] > 0 for item in result.report["singularities"])
    image = direction_picture(result)
    assert image.shape[1] == PANEL_WIDTH
    assert ink(image, POSITIVE).sum() > 100
    assert ink(image, NEGATIVE).sum() < 20
    ring = DirectionFields(torus(32, 16), 1)
    picture = direction_picture(ring.result(trivial_connection(ring.mesh, 1, {280: 1.0, 264: -1.0})))
    assert ink(picture, POSITIVE).sum() > 100
    assert ink(picture, NEGATIVE).sum() > 100


def test_killing_fields_have_a_panel_each() -> None:
    """Two fields are two panels of arrows."""
    image = killing_picture(killing_fields(icosphere(2), 2))
    assert image.shape[1] == 2 * PANEL_WIDTH
    dark = np.asarray(image).max(axis=2) < 60
    assert dark[:, :PANEL_WIDTH].sum() > 1000
    assert dark[:, PANEL_WIDTH:].sum() > 1000
