"""The video server and the bridge as nodes on a ROS master of their own."""

from __future__ import annotations

import asyncio
import contextlib
import json
import signal
import socket
import stat
import statistics
import time
import urllib.error
import urllib.request
from pathlib import Path

import aiohttp
import numpy as np
import pytest
import simplejpeg
from waiting import wait_until
from web_harness import START, Ros

from telex_experiments.rigs.private_master import free_port

pytestmark = [pytest.mark.ros, pytest.mark.waiting]

CAMERA = "/telex/cameras/front/image_raw"
COMPRESSED = f"{CAMERA}/compressed"
DRIVE = "/telex/track_teleop/cmd_vel"
NOISE = np.random.default_rng(2).integers(0, 255, (240, 320, 3), np.uint8)
JPEG = simplejpeg.encode_jpeg(NOISE, quality=90)


@pytest.fixture(scope="module")
def ros():
    with Ros() as ros:
        yield ros


@pytest.fixture(scope="module")
def probe(ros):
    return ros.probe()


@pytest.fixture(scope="module")
def video(ros):
    return ros.serve("video_server")[1]


@pytest.fixture(scope="module")
def bridge(ros):
    # A busy machine connects a node in longer than the default gives the first message.
    return ros.serve("rosbridge", None, "_connect_timeout:=10.0")[1]


@pytest.fixture
def camera(probe):
    """Publish one JPEG at 30 Hz for the time of a test."""
    kind = "sensor_msgs/CompressedImage"
    hex_data = {"data": JPEG.hex()}
    probe.publish(COMPRESSED, kind, {"format": "jpeg"}, hex=hex_data, rate=30)
    yield
    probe.publish(COMPRESSED, kind, {"format": "jpeg"}, hex=hex_data)


def get(url):
    try:
        with urllib.request.urlopen(url, timeout=10) as reply:
            return reply.status, reply.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def answers(url):
    """Whether a server has begun its work: one that is bound only does not answer."""
    with contextlib.suppress(OSError):
        return bool(get(url)[0])
    return False


def open_stream(url, target, receive_buffer=None):
    host, port = url[len("http://") :].split(":")
    client = socket.socket()
    if receive_buffer:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
    client.settimeout(10.0)
    client.connect((host, int(port)))
    client.sendall(f"GET {target} HTTP/1.0\r\n\r\n".encode())
    return client


def read_parts(client, count):
    """Return (time of arrival, X-Timestamp, data) of the next parts of a stream."""
    parts, buffered = [], b""
    stream = client.makefile("rb")
    while len(parts) < count:
        line = stream.readline()
        assert line, "the stream has ended"
        if line.startswith(b"X-Timestamp"):
            stamp = float(line.split()[1])
        elif line.startswith(b"Content-Length"):
            length = int(line.split()[1])
            assert stream.readline() == b"\r\n"
            parts.append((time.monotonic(), stamp, stream.read(length)))
    assert not buffered
    return parts


# Video server


def test_a_stream_delivers_the_published_bytes(video, camera):
    with open_stream(video, f"/stream?topic={CAMERA}") as client:
        parts = read_parts(client, 20)
    arrivals, stamps, pictures = zip(*parts)
    assert set(pictures) == {JPEG}
    # Each that was published comes once; what the publisher makes up after a pause, in a burst.
    assert list(stamps) == sorted(set(stamps))
    assert np.median(np.diff(arrivals)) < 0.1


def test_the_server_subscribes_only_while_somebody_watches(ros, video, camera):
    wait_until(lambda: not ros.subscribers(COMPRESSED))
    with open_stream(video, f"/stream?topic={CAMERA}") as client:
        read_parts(client, 1)
        assert ros.subscribers(COMPRESSED) == ["/telex/video_server"]
        assert ros.subscribers(CAMERA) == []
    wait_until(lambda: not ros.subscribers(COMPRESSED))


def test_a_stalled_client_delays_nobody_and_gets_fresh_pictures_on_resume(video, camera):
    stalled = open_stream(video, f"/stream?topic={CAMERA}", receive_buffer=65536)
    with stalled, open_stream(video, f"/stream?topic={CAMERA}") as reader:
        parts = read_parts(reader, 60)
        gaps = np.diff([arrival for arrival, _, _ in parts])
        assert np.median(gaps) < 0.05
        resumed = time.time()
        stale = [stamp for _, stamp, _ in read_parts(stalled, 20) if stamp < resumed - 0.25]
    assert len(stale) <= 6


def test_raw_images_are_encoded(probe, video):
    pixels = np.full((48, 64, 3), (200, 30, 30), np.uint8)
    fields = {"height": 48, "width": 64, "step": 192, "encoding": "rgb8"}
    hex_data = {"data": pixels.tobytes().hex()}
    probe.publish("/telex/raw", "sensor_msgs/Image", fields, hex=hex_data, rate=20)
    with urllib.request.urlopen(f"{video}/snapshot?topic=raw&height=24", timeout=10) as reply:
        picture = simplejpeg.decode_jpeg(reply.read(), colorspace="RGB")
    assert picture.shape == (24, 64, 3)
    assert np.abs(picture.astype(int) - (200, 30, 30)).max() < 12


def test_unknown_topics_and_the_console(video, bridge, camera):
    status, text = get(f"{video}/stream?topic=/no/such/topic")
    assert status == 404
    assert "No image topic" in text
    assert get(f"{video}/stream?topic={CAMERA}&quality=500")[0] == 400
    assert CAMERA in get(f"{video}/streams")[1]
    assert "<title>Telex console</title>" in get(f"{video}/")[1]
    config = json.loads(get(f"{video}/config.json")[1])
    assert config == {
        "namespace": "/telex",
        "rosbridge": bridge,
        "cameras": [{"name": "front", "topic": CAMERA}],
        "hidden_cameras": ["overview"],
        "main_camera": "front",
        "main_rate": 30.0,
        "thumbnail_rate": 10.0,
        "thumbnail_width": 320,
    }


def test_another_process_mounts_pages_by_a_parameter(ros, tmp_path):
    (tmp_path / "index.html").write_text("exercises")
    process, url = ros.serve("video_server", "mounting")
    parameter = "/telex/mounting/mounts/training"
    assert get(f"{url}/training/")[0] == 404
    ros.master.setParam(parameter, {"folder": str(tmp_path)})
    assert get(f"{url}/training/") == (200, "exercises")
    ros.stop(process)
    process, url = ros.serve("video_server", "mounting")
    wait_until(lambda: answers(url))
    assert get(f"{url}/training/") == (200, "exercises")
    ros.master.deleteParam(parameter)
    assert get(f"{url}/training/")[0] == 404
    ros.stop(process)


@pytest.mark.parametrize("name", ["video_server", "rosbridge"])
def test_a_port_in_use_is_one_clear_line(ros, name):
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        process = ros.start_node(
            name, f"_port:={port}", f"__name:={name}_2", stdout=-1, stderr=-1, text=True
        )
        _, said = process.communicate(timeout=START)
    assert process.returncode == 1
    assert f"/telex/{name}_2/port: {port} on 127.0.0.1 is in use by another program" in said
    assert "Traceback" not in said
    assert len([line for line in said.splitlines() if line.strip()]) == 1


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_server_leaves_at_once_with_streams_open(ros, camera, number):
    process, url = ros.serve("video_server", "short_lived")
    clients = [open_stream(url, f"/stream?topic={CAMERA}") for _ in range(3)]
    for client in clients[:2]:
        read_parts(client, 2)
    started = time.monotonic()
    assert ros.stop(process, number) == 0
    # aiohttp by itself would wait a minute for the streams' end
    assert time.monotonic() - started < 10.0
    for client in clients:
        client.close()
    assert ros.param("/telex/short_lived/url") is None


# Bridge


def in_thread(call, *arguments):
    return asyncio.get_running_loop().run_in_executor(None, call, *arguments)


def on_bridge(bridge, check):
    async def connected():
        async with aiohttp.ClientSession() as http, http.ws_connect(bridge) as socket:
            client = Client(socket)
            await check(client)

    asyncio.run(asyncio.wait_for(connected(), 30.0))


class Client:
    def __init__(self, socket):
        self.socket = socket

    async def say(self, op, **fields):
        await self.socket.send_json({"op": op, **fields})

    async def hear(self):
        return await self.socket.receive_json(timeout=10)

    async def ask(self, service, args=None):
        await self.say("call_service", service=service, args=args or {}, id="q")
        answer = await self.hear()
        return answer["result"], answer["values"]


def test_the_first_message_after_advertise_arrives(probe, bridge):
    probe.subscribe("/chat", "std_msgs/String")

    async def check(client):
        await client.say("advertise", topic="/chat", type="std_msgs/String")
        for word in ("one", "two"):
            await client.say("publish", topic="/chat", msg={"data": word})
        await in_thread(wait_until, lambda: len(probe.heard["/chat"]) == 2)

    on_bridge(bridge, check)
    assert probe.messages("/chat") == [{"data": "one"}, {"data": "two"}]


def test_topics_are_heard_throttled_and_latched(probe, bridge):
    probe.publish("/telex/scene", "std_msgs/String", {"data": "floor"}, latch=True)
    states = {"name": ["a"], "position": [0.5, float("nan")]}
    probe.publish("/telex/joint_states", "sensor_msgs/JointState", states, rate=100)

    async def check(client):
        await client.say("subscribe", topic="/telex/scene")
        assert (await client.hear())["msg"] == {"data": "floor"}
        await client.say("subscribe", topic="/telex/scene", id="again")
        await client.say("subscribe", topic="joint_states", throttle_rate=100)
        stamps = []
        for _ in range(11):
            heard = await client.hear()
            assert (heard["topic"], heard["msg"]["position"]) == ("joint_states", [0.5, None])
            stamp = heard["msg"]["header"]["stamp"]
            stamps.append(stamp["secs"] + 1e-9 * stamp["nsecs"])
        periods = [after - before for before, after in zip(stamps, stamps[1:])]
        assert 0.08 < statistics.median(periods) < 0.15

    on_bridge(bridge, check)

    async def later(client):
        await client.say("subscribe", topic="/telex/scene")
        assert (await client.hear())["msg"] == {"data": "floor"}

    on_bridge(bridge, later)


def test_services_and_parameters(ros, probe, bridge):
    kind = "std_srvs/SetBool"
    probe.do("serve", service="/telex/lamp", type=kind, response={"success": True, "message": "on"})

    async def check(client):
        lamp = {"success": True, "message": "on"}
        assert await client.ask("lamp", {"data": True}) == (True, lamp)
        assert await client.ask("/rosapi/service_type", {"service": "/telex/lamp"}) == (
            True,
            {"type": kind},
        )
        assert "/telex/lamp" in (await client.ask("rosapi/services"))[1]["services"]
        failed, why = await client.ask("/telex/no_lamp")
        assert (failed, why) == (False, "there is no service /telex/no_lamp")
        value = {"name": "/telex/limits", "value": '{"speed": 1.5, "names": ["a"]}'}
        assert (await client.ask("/rosapi/set_param", value))[0]
        answer = await client.ask("rosapi/get_param", {"name": "limits"})
        assert json.loads(answer[1]["value"]) == {"speed": 1.5, "names": ["a"]}
        names = (await client.ask("rosapi/get_param_names"))[1]["names"]
        assert "/telex/limits/speed" in names
        assert (await client.ask("rosapi/delete_param", {"name": "limits"}))[0]
        assert (await client.ask("rosapi/get_param", {"name": "limits"}))[1] == {"value": "null"}
        assert not (await client.ask("rosapi/delete_param", {"name": "limits"}))[0]
        assert "/telex/rosbridge" in (await client.ask("/rosapi/nodes"))[1]["nodes"]
        now = (await client.ask("/rosapi/get_time"))[1]["time"]
        assert abs(now["secs"] - time.time()) < 10

    on_bridge(f"{bridge}/?role=instructor", check)
    assert probe.requests == [{"data": True}]
    assert ros.param("/telex/limits") is None


def test_a_client_that_is_killed_stops_what_it_drove(probe, bridge):
    probe.subscribe(DRIVE, "geometry_msgs/Twist")

    async def check(client):
        await client.say("advertise", topic=DRIVE, type="geometry_msgs/Twist")
        await client.say("publish", topic=DRIVE, msg={"linear": {"x": 1}})
        await in_thread(wait_until, lambda: probe.heard[DRIVE])
        client.socket._response.connection.transport.abort()

    on_bridge(bridge, check)
    wait_until(lambda: len(probe.heard[DRIVE]) == 2)
    assert [message["linear"]["x"] for message in probe.messages(DRIVE)] == [1.0, 0.0]


def test_nonsense_moves_nothing_and_the_bridge_lives_on(probe, bridge):
    topic = "/telex/arm_teleop/delta_joint_cmds"
    probe.subscribe(topic, "control_msgs/JointJog")
    jog = {"joint_names": ["turret_joint"], "velocities": ["fast"]}

    async def check(client):
        await client.say("advertise", topic=topic, type="control_msgs/JointJog")
        await client.say("publish", topic=topic, msg=jog)
        assert (await client.hear())["msg"] == (
            f"publish to {topic}: velocities[0]: expected a number, got a string"
        )
        for text in ("{", "[" * 50000, '{"op":"fly"}', "null"):
            await client.socket.send_str(text)
            assert (await client.hear())["level"] == "error"
        huge = json.dumps({"op": "publish", "topic": topic, "msg": "x" * 2000000})
        # It is refused by its length, so that the connection may end before all of it is sent.
        with contextlib.suppress(ConnectionError):
            await client.socket.send_str(huge)
        kinds = (aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSED, aiohttp.WSMsgType.ERROR)
        assert (await client.socket.receive(timeout=10)).type in kinds

    on_bridge(bridge, check)

    async def still_there(client):
        assert (await client.ask("/rosapi/get_time"))[0]

    on_bridge(bridge, still_there)
    assert probe.messages(topic) == []


def test_tokens_that_the_bridge_made_stand_in_files_of_its_user_alone(ros, bridge):
    process = ros.start_node(
        "rosbridge",
        "_port:=0",
        "_address:=0.0.0.0",
        "__name:=open",
        stdout=-1,
        stderr=-1,
        text=True,
    )
    url = wait_until(lambda: ros.param("/telex/open/url"), timeout=START)
    files = [Path(ros.param(f"/telex/open/{each}token_file")) for each in ("", "instructor_")]
    for file in files:
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
    client, instructor = (file.read_text().strip() for file in files)
    assert client not in str(ros.master.getParam("/"))
    assert instructor not in str(ros.master.getParam("/"))

    async def check(watcher):
        await watcher.say("subscribe", topic="/rosout", type="rosgraph_msgs/Log")
        await watcher.say("subscribe", topic="bridge/clients")
        while True:
            heard = await watcher.hear()
            assert client not in json.dumps(heard)
            assert instructor not in json.dumps(heard)
            # The other bridge, which nobody uses now, tells of its clients on the same topic.
            if heard["topic"] == "bridge/clients" and heard["msg"]["clients"]:
                assert heard["msg"]["clients"][0]["role"] == "instructor"
                return

    on_bridge(f"{url}/?role=instructor&token={instructor}", check)
    # The video server knows them as long as the bridge runs.
    pictures, page = ros.serve("video_server", "shown", "_address:=0.0.0.0", "_rosbridge:=open")
    streams = f"{page}/streams?token={client}"
    assert [get(each)[0] for each in (f"{page}/streams", streams)] == [401, 200]
    # One that crashes leaves them to its successor, but not one that ends in order.
    ros.stop(process, signal.SIGKILL)
    process = ros.start_node("rosbridge", "_port:=0", "_address:=0.0.0.0", "__name:=open")
    host, port = url[len("ws://") :].split(":")
    wait_until(lambda: answers(f"http://{host}:{port}/"), timeout=START)
    assert [file.read_text().strip() for file in files] == [client, instructor]
    ros.stop(process)
    assert get(streams)[0] == 401
    assert [file.exists() for file in files] == [False, False]
    ros.stop(pictures)
    written = {path: path.read_text(errors="replace") for path in ros.logs.rglob("*.log*")}
    assert written
    for text in written.values():
        assert client not in text
        assert instructor not in text


@pytest.mark.parametrize("name", ["video_server", "rosbridge"])
@pytest.mark.parametrize("parameter", ["token", "token_file"])
def test_a_token_that_others_can_read_ends_the_start(ros, tmp_path, name, parameter):
    file = tmp_path / "token"
    file.write_text("sesame")
    file.chmod(0o644)
    process = ros.start_node(
        name,
        "_port:=0",
        f"_{parameter}:={'sesame' if parameter == 'token' else file}",
        f"__name:={name}_{parameter}",
        stdout=-1,
        stderr=-1,
        text=True,
    )
    _, said = process.communicate(timeout=START)
    assert process.returncode == 1
    wanted = "give token_file" if parameter == "token" else "(mode 0644); delete it"
    assert wanted in said
    assert "sesame" not in said
    assert "Traceback" not in said


def test_the_launch_file_starts_both_nodes():
    with Ros() as ros:
        ports = {"video_port": free_port(), "bridge_port": free_port()}
        arguments = [f"{name}:={port}" for name, port in ports.items()]
        environment = {**ros.environment, "ROS_NAMESPACE": "/telex"}
        ros.environment = environment
        launched = ros.start(
            ["roslaunch", "telex_teleop", "console.launch", *arguments], stdout=-3, stderr=-3
        )
        url = wait_until(lambda: ros.param("/telex/video_server/url"), timeout=START)
        assert url == f"http://127.0.0.1:{ports['video_port']}"
        bridge = wait_until(lambda: ros.param("/telex/rosbridge/url"), timeout=START)
        assert bridge == f"ws://127.0.0.1:{ports['bridge_port']}"
        assert json.loads(get(f"{url}/config.json")[1])["rosbridge"] == bridge
        ros.stop(launched)
        assert ros.param("/telex/video_server/url") is None
        assert ros.param("/telex/rosbridge/url") is None
