"""Time from ``sim/load_scene`` to the first picture of the new scene."""

from __future__ import annotations

import time
from typing import List, Sequence

import rospy
from telex_msgs.msg import SceneDescription
from telex_msgs.srv import LoadScene

from telex_experiments.rigs.private_simulator import PrivateSimulator
from telex_experiments.rigs.report import Figure
from telex_experiments.rigs.stream_reader import StreamReader

_CAMERA = "/telex/cameras/front/image_raw"
_REST = 1.0
"""Between two changes (s)."""

_START = 8.0
"""Time (s) from the first picture on in which other nodes still start, and take the processors."""


def change_figures(
    simulator: PrivateSimulator, judged: bool, changing: Sequence[str]
) -> List[Figure]:
    """Load one scene after the other in the whole simulator, whose master is this node's.

    Parameters
    ----------
    judged : bool
        Whether the scenes have been prepared, so that they have to come soon.
    changing : sequence of str
        Names of scenes.
    """
    stamps: List[float] = []
    figures: List[Figure] = []
    url = simulator.wait_for_param("/telex/video_server/url")
    subscriber = rospy.Subscriber(
        "/telex/sim/scene",
        SceneDescription,
        lambda scene: stamps.append(scene.header.stamp.to_sec()),
    )
    simulator.wait_for("scene", lambda: stamps)
    simulator.wait_for("camera", _camera_is_there)
    viewer = StreamReader(url)
    simulator.wait_for("camera picture", lambda: viewer.arrivals)
    load = rospy.ServiceProxy("/telex/sim/load_scene", LoadScene)
    time.sleep(_START if judged else 0.0)
    for scene in changing:
        time.sleep(_REST)
        before, asked = len(stamps), time.monotonic()
        answer = load(scene)
        answered = time.monotonic() - asked
        if not answer.success:
            raise RuntimeError(f"sim/load_scene {scene}: {answer.message}")
        simulator.wait_for("scene", lambda before=before: len(stamps) > before)
        # No picture of the old scene has a stamp as late as the new scene's.
        came = simulator.wait_for(
            "picture", lambda: [at for stamp, at in viewer.arrivals if stamp >= stamps[-1]]
        )
        most = 1.0 if judged else None
        figures.append(Figure(f"{scene}: the call is answered", answered, "s"))
        figures.append(Figure(f"{scene}: first picture", came[0] - asked, "s", at_most=most))
    subscriber.unregister()
    return figures


def _camera_is_there() -> bool:
    return f"{_CAMERA}/compressed" in {name for name, _ in rospy.get_published_topics()}
