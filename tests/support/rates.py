"""Convergence rates, fitted by least squares."""

from collections.abc import Sequence

import numpy as np


def fitted_rate(widths: Sequence[float], errors: Sequence[float]) -> float:
    """Return the order p of errors C·hᵖ: the least-squares slope of log(error) over log(h), on three levels or more."""
    assert len(widths) == len(errors) >= 3
    return float(np.polyfit(np.log(widths), np.log(errors), 1)[0])
