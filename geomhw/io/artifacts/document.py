"""JSON documents."""

import json
from pathlib import Path
from typing import Any

from geomhw.errors import FormatError
from geomhw.io.file_bytes import content


def read_json(path: str | Path) -> Any:
    """What the document holds; NaN and Infinity are numbers."""
    path = Path(path)
    try:
        return json.loads(content(path).decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{path.name} cannot be read as JSON: {error}") from None
