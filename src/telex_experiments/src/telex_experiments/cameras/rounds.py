"""Draws the recorded scene once for each line that it reads, and writes what a picture cost (ms).

It runs by its path, with the sources of any revision in ``PYTHONPATH``: see `compared`.
"""

from __future__ import annotations

import os
import sys
from typing import Any


def main() -> None:
    """Draw, until there is nothing more to read."""
    os.environ.setdefault("LP_NUM_THREADS", "0")
    import cv2

    from telex_experiments.cameras import renderer as recorded
    from telex_sim.cameras.drawing.gl_context import create_context
    from telex_sim.cameras.drawing.light.daylight import Lighting
    from telex_sim.cameras.drawing.quality import TIERS
    from telex_sim.cameras.drawing.renderer import Renderer

    cv2.setNumThreads(1)
    renderer = Renderer(create_context(), TIERS["software"], Lighting(), recorded.package_path)
    # Older revisions call them Views.
    kind: Any = getattr(recorded, "RobotViews", None) or vars(recorded)["Views"]
    views = kind(recorded.NAMES, recorded.LARGE)
    views.load(renderer)
    # Programs that a scene may need later are compiled between the first pictures.
    for number in range(1, 6):
        views.round(renderer, number)
    for number, _ in enumerate(sys.stdin):
        print(f"cost {1e3 * views.round(renderer, number).cpu:.6f}", flush=True)


if __name__ == "__main__":
    main()
