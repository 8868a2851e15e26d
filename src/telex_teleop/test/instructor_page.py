"""The instructor's page in headless Chromium, and a simulator that is played: what tests share."""

from __future__ import annotations

import pytest
from console_page import opened, robot, ros
from waiting import wait_until

__all__ = [
    "BROKEN",
    "HALL",
    "START",
    "VIEW",
    "YARD",
    "Simulator",
    "answer",
    "outside",
    "page",
    "robot",
    "ros",
    "simulator",
]

VIEW = "/telex/cameras/overview/view"
HALL = {"name": "hall", "description": "A large hall.", "path": "/scenes/hall.yaml"}
YARD = {
    "name": "yard",
    "description": "A step and a crate.",
    "path": "/scenes/yard.yaml",
    "picture": [0xFF, 0xD8, 0xFF, 0xD9],
}
HIDDEN = {"name": "measured", "path": "/scenes/measured.yaml", "hidden": True}
BROKEN = {"name": "broken", "path": "/scenes/broken.yaml", "problem": "no YAML"}

START = {
    "mode": "orbit",
    "azimuth": 1.0,
    "elevation": 0.5,
    "distance": 4.0,
    "center": {"x": 0.0, "y": 0.0, "z": 0.2},
}
"""View of the overview camera at first."""


class Simulator:
    """Plays the simulator's services."""

    def __init__(self, robot):
        self.robot = robot
        self.probe = robot.probe
        for name in ("pause", "unpause", "reset"):
            self.serve(name, "std_srvs/Empty")
        self.serve("step", "telex_msgs/Step", success=True)
        self.probe.subscribe(VIEW, "telex_msgs/OverviewView")
        self.reset()

    def reset(self):
        """Forget what was asked, and be in the first scene, at rest."""
        scenes = [HALL, YARD, BROKEN, HIDDEN]
        self.serve("list_scenes", "telex_msgs/ListScenes", scenes=scenes, current=HALL["path"])
        self.tell()
        self.robot.publish_camera("overview", rate=1)
        self.probe.forget_requests()

    def serve(self, name, kind, delay=0.0, held=False, **response):
        order = {"service": f"/telex/sim/{name}", "type": kind, "response": response}
        self.probe.do("serve", delay=delay, held=held, **order)

    def release(self, name):
        """Let a service answer, which was held until now."""
        self.probe.do("release", service=f"/telex/sim/{name}")

    def tell(self, **changes):
        self.robot.publish_sim(world="hall", step_size=0.002, resets=3, **changes)

    def send_view(self, view):
        """Send the overview camera somewhere, as another page would."""
        self.probe.publish(VIEW, "telex_msgs/OverviewView", view, latch=True)

    def asked(self, name):
        """Requests of a service so far."""
        return self.probe.requests_of(f"/telex/sim/{name}")


@pytest.fixture(scope="module")
def simulator(robot):
    return Simulator(robot)


@pytest.fixture(scope="module")
def page(ros, simulator):
    start = {**START, "center": list(START["center"].values())}
    ros.master.setParam("/telex/cameras/overview/start", start)
    _, url = ros.serve("video_server")
    ros.bridge, _ = ros.serve("rosbridge")
    with opened(f"{url}/instructor") as page:
        yield page


def answer(page, button):
    """Press a button of the question that is open."""
    wait_until(lambda: page.element("#ask").is_displayed())
    sentence = page.text("ask-sentence")
    page.element(f"#ask-{button}").click()
    wait_until(lambda: not page.element("#ask").is_displayed())
    return sentence


def outside(page):
    """Parts of the page that are not wholly on the screen."""
    return page.script("""
        const inside = ({left, top, right, bottom}) =>
          left >= -1 && top >= -1 && right <= innerWidth + 1 && bottom <= innerHeight + 1;
        const parts = "main .card, .card button, .view, .thumbnail, header > *, footer > *";
        return [...document.querySelectorAll(parts)]
          .filter((each) => each.offsetParent !== null && !each.closest("ol"))
          .filter((each) => !inside(each.getBoundingClientRect()))
          .map(({id, className}) => `${id} ${className}`);
    """)
