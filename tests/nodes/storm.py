"""Four clients that load, start, stop, unload and list controllers at once, as fast as they can.

Run as a program, `storm.py SECONDS` prints what came of it as JSON.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from typing import Any, Dict

import rospy
from std_srvs.srv import Trigger

from telex_control.manager.client import BEST_EFFORT, STRICT, ControllerManagerClient

CLIENTS = 4
STUCK_AFTER = 20.0
"""Time (s) that a round may take when the storm is over."""


def storm(duration: float) -> Dict[str, Any]:
    """Let the storm rage.

    Parameters
    ----------
    duration : float
        Wall time (s).

    Returns
    -------
    dict
        ``rounds``: of each client; ``problems``: what was refused that should not have been;
        ``stuck``: how many clients never came back; ``gaps``: of the node control_loop, by how
        much (s) its longest period was too long, and that of a process which only sleeps.
    """
    manager = ControllerManagerClient()
    rospy.wait_for_service("control_loop/worst_gap", timeout=120.0)
    worst_gap = rospy.ServiceProxy("control_loop/worst_gap", Trigger)
    worst_gap()
    end = time.monotonic() + duration
    rounds, problems = [0] * CLIENTS, []  # type: List[int], List[str]

    def expect(condition: bool, what: str) -> None:
        if not condition:
            raise RuntimeError(what)

    def client(index: int) -> None:
        name = f"storm_controller_{index}"
        try:
            while time.monotonic() < end:
                expect(manager.load(name), "not loaded")
                # Two of them want the same joint, so that a start may be refused.
                if manager.switch([name], [], BEST_EFFORT):
                    listed = [each.name for each in manager.list_controllers()]
                    expect(name in listed, "not listed")
                    expect(manager.switch([], [name], STRICT), "not stopped")
                expect(manager.unload(name), "not unloaded")
                rounds[index] += 1
        except Exception as error:
            problems.append(f"{name}: {error!r}")

    threads = [threading.Thread(target=client, args=(i,), daemon=True) for i in range(CLIENTS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(max(0.0, end + STUCK_AFTER - time.monotonic()))
    return {
        "rounds": rounds,
        "problems": problems,
        "stuck": sum(thread.is_alive() for thread in threads),
        "gaps": json.loads(worst_gap().message),
    }


if __name__ == "__main__":
    rospy.init_node("storm", anonymous=True)
    print(json.dumps(storm(float(sys.argv[1]))))
