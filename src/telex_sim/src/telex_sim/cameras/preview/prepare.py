"""Draws the shipped scenes once, for what is kept of that.

This is ``python -m telex_sim.cameras.preview.prepare``.

Textures and meshes then lie in the content store, compiled shaders where the driver keeps them, and
the cameras' node shows each scene soon after it has been asked for.
"""

from __future__ import annotations

import logging
import os
import sys
from dataclasses import replace

from telex_control.common.file_catalog import package_path

from ...scene.catalog import scenes
from ...scene.content_store import ContentStore, cache_folder
from ..cameras_config import CamerasConfig, shipped_cameras
from ..drawing.gl_context import NoContextError, create_context
from ..drawing.light.daylight import Lighting
from ..drawing.quality import choose_quality
from ..drawing.renderer import Renderer
from .scene_preview import Subject, settled, with_lamps


def main() -> int:
    """Prepare all scenes, those of the user's folders as well; returns the exit status."""
    logging.getLogger("rosout").setLevel(logging.WARNING)
    folder = cache_folder("content")
    if folder is None:
        print("there is no cache folder: scenes are prepared whenever they are shown")
        return 0
    config = shipped_cameras()
    os.environ.setdefault("LP_NUM_THREADS", str(config.software_threads))
    try:
        context = create_context(config.egl_device)
    except NoContextError as error:
        print(f"no scene is prepared: {error}")
        return 0
    renderer = Renderer(
        context,
        choose_quality(config.quality, context.info["GL_RENDERER"]),
        replace(Lighting(), shadow_radius=config.shadow_radius),
        package_path,
        ContentStore(folder),
    )
    for name in scenes():
        print(f"{name} ...", flush=True)
        draw(settled(name, seconds=0.0), config, renderer)
    renderer.release()
    return 0


def draw(subject: Subject, config: CamerasConfig, renderer: Renderer) -> None:
    """Take a picture with each of the robot's cameras, its lamps off and on."""
    subject = with_lamps(subject, 1.0)
    renderer.load_scene(subject.scene)
    lamps = [lamp.name for lamp in subject.scene.lamps if lamp.name]
    for level in (0.0, 1.0):
        renderer.set_lamp_levels({name: level for name in lamps})
        for camera in config.cameras.values():
            pose = subject.frame(f"{subject.model}/{camera.frame}")
            if pose is not None:
                renderer.place(subject.frames_in_world, pose[:3, 3])
                for coarse in (False, True):
                    renderer.render(camera.pinhole(), pose, coarse=coarse)


if __name__ == "__main__":
    sys.exit(main())
