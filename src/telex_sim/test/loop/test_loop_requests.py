"""What other threads ask of the simulation's loop."""

from __future__ import annotations

import threading

from telex_sim.engine.loop_requests import LoopRequests


def test_the_loop_makes_up_for_each_part_before_the_next():
    now, done = [100.0], []
    requests = LoopRequests(lambda: now[0])

    def parts():
        for number in range(2):
            now[0] += 0.01
            done.append(number)
            yield

    def ask():
        requests.carry_out(parts)
        requests.carry_out(lambda: done.append("next"))

    asking = threading.Thread(target=ask)
    asking.start()
    while not done:
        requests.serve()
    for _ in range(3):
        requests.serve()
    assert done == [0]
    now[0] += 0.019
    requests.serve()
    assert done == [0]
    now[0] += 0.0011
    requests.serve()
    assert done == [0, 1]
    while asking.is_alive():
        now[0] += 0.01
        requests.serve()
    assert done == [0, 1, "next"]
