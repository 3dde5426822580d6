"""What the output folder of a run holds."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def summary_of(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "summary.json").read_text(encoding="utf-8"))
