"""An exam's list with real nodes: bridge and video server on a master, and their crashes."""

from __future__ import annotations

import asyncio
import signal
import urllib.error
import urllib.request

import aiohttp
import pytest
from waiting import wait_until
from web_harness import Ros

pytestmark = [pytest.mark.ros, pytest.mark.waiting]

TRIAL = "2026-11-25_210000_ann_slalom"
TRUTH, ALLOWED = "/telex/sim/poses_of_all", "/telex/joint_states"
BOTH = {TRUTH, ALLOWED}


@pytest.fixture(scope="module")
def ros():
    with Ros() as started:
        yield started


@pytest.fixture
def station(ros, tmp_path):
    """Nodes with an instructor's token, and somebody who plays the training node."""
    token = tmp_path / "teacher.token"
    token.write_text("teacher")
    token.chmod(0o600)
    bridge, url = ros.serve("rosbridge", None, f"_instructor_token_file:={token}", "_plain:=true")
    _, video = ros.serve("video_server")
    ros.master.setParam("/telex/video_server/mounts/progress", {"folder": str(tmp_path)})
    (tmp_path / "index.html").write_text("progress")
    probe = ros.probe()
    probe.publish(TRUTH, "std_msgs/String", {"data": "secret"}, rate=20)
    probe.publish(ALLOWED, "sensor_msgs/JointState", {}, rate=20)
    training = ros.probe()
    return bridge, url, video, probe, training, f"_instructor_token_file:={token}"


def status_of(url):
    try:
        return urllib.request.urlopen(url, timeout=10.0).status
    except urllib.error.HTTPError as error:
        return error.code


async def ask(socket, service, args=None):
    """Whether a service does what a client asks."""
    await socket.send_json(
        {"op": "call_service", "service": service, "args": args or {}, "id": "q"}
    )
    while True:
        said = await socket.receive_json(timeout=10.0)
        if said.get("id") == "q":
            values = said["values"]
            return said["result"] and not (
                isinstance(values, dict) and values.get("success") is False
            )


async def topics_of(socket, expected):
    """Return which of both topics the bridge lets through, besides what was on its way.

    Those that are expected are waited for, and so is the bridge's word that it has heard of both;
    another one then has a second.
    """
    await ask(socket, "/rosapi/get_time")
    for topic in BOTH:
        await socket.send_json({"op": "subscribe", "topic": topic})
    await socket.send_json({"op": "call_service", "service": "/rosapi/get_time", "id": "after"})
    heard, answered, loop = set(), set(), asyncio.get_running_loop()

    async def listen(duration, enough):
        until = loop.time() + duration
        while not enough() and loop.time() < until:
            try:
                said = await socket.receive_json(timeout=max(0.01, until - loop.time()))
            except asyncio.TimeoutError:
                return
            heard.update({said["topic"]} if said["op"] == "publish" else ())
            answered.update({"after"} & {said.get("id")})

    await listen(10.0, lambda: heard >= expected and answered)
    await listen(1.0, lambda: heard == BOTH)
    return heard


def test_a_list_holds_for_all_connections_through_crashes_until_an_instructor_ends_it(ros, station):
    bridge, url, video, probe, training, token = station

    def holds():
        return ros.param("/telex/rosbridge/exam") == TRIAL

    async def check():
        async with aiohttp.ClientSession() as http:
            async with http.ws_connect(url) as early:
                assert await topics_of(early, BOTH) == BOTH
                assert status_of(f"{video}/progress/") == 200
                training.publish(
                    "/telex/training/exam", "std_msgs/String", {"data": TRIAL}, latch=True
                )
                await asyncio.get_running_loop().run_in_executor(None, wait_until, holds)
                assert await topics_of(early, {ALLOWED}) == {ALLOWED}
                async with http.ws_connect(f"{url}?name=other") as late:
                    assert await topics_of(late, {ALLOWED}) == {ALLOWED}
                    assert not await ask(late, "bridge/end_exam")
                    assert not await ask(late, "/rosapi/get_param", {"name": "/rosdistro"})
                with pytest.raises(aiohttp.WSServerHandshakeError):
                    await http.ws_connect(f"{url}?role=instructor&token=guess")
            wait_until(lambda: status_of(f"{video}/progress/") == 403)
            # Whoever plays the training node has died, and the bridge is killed.
            ros.stop(training._process, signal.SIGKILL)
            ros.stop(bridge, signal.SIGKILL)
            ros.master.deleteParam("/telex/rosbridge/url")
            _, again = ros.serve("rosbridge", None, token, "_plain:=true")
            async with http.ws_connect(again) as new:
                assert await topics_of(new, {ALLOWED}) == {ALLOWED}
            assert status_of(f"{video}/progress/") == 403
            teacher = f"{again}?role=instructor&token=teacher"
            async with http.ws_connect(teacher) as instructor, http.ws_connect(again) as trainee:
                assert await topics_of(instructor, BOTH) == BOTH
                assert await ask(instructor, "bridge/end_exam")
                assert await topics_of(trainee, BOTH) == BOTH
            wait_until(lambda: status_of(f"{video}/progress/") == 200)
            assert not holds()

    asyncio.run(asyncio.wait_for(check(), 120.0))
