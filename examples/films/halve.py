"""Halve a film: ``python halve.py IN.gif OUT.gif``."""

import sys

import numpy as np
from PIL import Image, ImageSequence

from geomhw.io.film import write_gif

pictures = []
for frame in ImageSequence.Iterator(Image.open(sys.argv[1])):
    picture = frame.convert("RGB")
    pictures.append(np.asarray(picture.resize((picture.width // 2, picture.height // 2), Image.Resampling.BOX)))
write_gif(sys.argv[2], pictures)
