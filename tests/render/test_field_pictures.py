"""Pictures of direction fields and Killing fields: crosses, singularities by sign, panels."""

import numpy as np

from geomhw.directions import DirectionFields, trivial_connection
from geomhw.mesh.primitives import icosphere, torus
from geomhw.render import Look, direction_picture, killing_picture
from geomhw.render.direction_picture import NEGATIVE, POSITIVE
from geomhw.spectral import killing_fields
from support.pictures import ink, needs_opengl

pytestmark = needs_opengl
WIDTH = 400
LOOK = Look(width=WIDTH)


def test_directions_and_singularities_are_seen() -> None:
    """Directions cover the mesh; lines on a sphere have positive singularities only, a torus with a pair both."""
    fields = DirectionFields(icosphere(3), 2)
    result = fields.result(fields.smoothest())
    assert all(item["index"] > 0 for item in result.report["singularities"])
    image = direction_picture(result, LOOK)
    assert image.shape[1] == WIDTH
    assert ink(image, POSITIVE).sum() > 50
    assert ink(image, NEGATIVE).sum() < 20
    ring = DirectionFields(torus(32, 16), 1)
    picture = direction_picture(ring.result(trivial_connection(ring.mesh, 1, {280: 1.0, 264: -1.0})), LOOK)
    assert ink(picture, POSITIVE).sum() > 50
    assert ink(picture, NEGATIVE).sum() > 50


def test_killing_fields_have_a_panel_each() -> None:
    """Two fields are two panels of arrows."""
    image = killing_picture(killing_fields(icosphere(2), 2), LOOK)
    assert image.shape[1] == 2 * WIDTH
    dark = np.asarray(image).max(axis=2) < 60
    assert dark[:, :WIDTH].sum() > 600
    assert dark[:, WIDTH:].sum() > 600
