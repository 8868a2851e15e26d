"""The video server beside several robots: each has its pictures, line, exam and tokens."""

from __future__ import annotations

import asyncio
import contextlib

import aiohttp
import pytest
from sample_pictures import jpeg
from waiting import wait_until_async
from web_fakes import HUNG, HUNG_TEST, FakePictures, served

from telex_control.common.params import ConfigError, read_config
from telex_teleop.web.line.fields import LineFields
from telex_teleop.web.server_config import VideoServerConfig
from telex_teleop.web.video.pictures import CompressedPicture
from telex_teleop.web.video.video_server_app import VideoServer

OWN, OTHER = (f"/{robot}/cameras/front/image_raw" for robot in ("telex", "telex_b"))
HIDDEN = "/telex_b/cameras/overview/image_raw"


class Bench:
    def __init__(self, tmp_path):
        self.pictures = FakePictures(
            {f"{topic}/compressed": "sensor_msgs/CompressedImage" for topic in (OWN, OTHER, HIDDEN)}
        )
        for name in ("index.html", "instructor.html"):
            (tmp_path / name).write_text("<!doctype html>")
        self.server = VideoServer(
            VideoServerConfig(robots=("telex_b",)), self.pictures, "/telex/", tmp_path, print
        )

    @contextlib.asynccontextmanager
    async def served(self):
        async with served(self.server.make_app()) as url, aiohttp.ClientSession(url) as http:
            yield http

    async def snapshot(self, http, topic, query=""):
        """Status of a snapshot for which a picture comes once somebody waits for it."""
        name = f"{topic}/compressed"
        asked = asyncio.ensure_future(http.get(f"/snapshot?topic={topic}{query}"))
        with contextlib.suppress(AssertionError):
            await wait_until_async(lambda: name in self.pictures.receivers or asked.done())
        while not asked.done():  # of the last snapshot, a receiver may be there before this one
            self.pictures.feed(name, CompressedPicture(1.0, jpeg(), 1.0))
            await asyncio.sleep(0.02)
        async with await asked as reply:
            return reply.status


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)


def run(coroutine):
    asyncio.run(asyncio.wait_for(coroutine, HUNG_TEST))


def tokens(bench, tmp_path):
    """Give each bridge tokens of its own."""
    for robot, place in (("telex", "rosbridge"), ("telex_b", "/telex_b/rosbridge")):
        for kind in ("token_file", "instructor_token_file"):
            file = tmp_path / f"{robot}_{kind}"
            file.write_text(f"{robot}-{kind[0]}")
            file.chmod(0o600)
            bench.pictures.params[f"{place}/{kind}"] = str(file)


def _of(robot, name):
    return name if robot == "telex" else f"/{robot}/{name}"


def test_the_page_is_told_of_the_robot_that_it_asks_for(bench):
    async def check():
        params = bench.pictures.params
        params["rosbridge/url"] = "ws://127.0.0.1:9090"
        params["/telex_b/rosbridge/url"] = "ws://127.0.0.1:9091"
        params["cameras/cameras"] = {"head": {"zoom_max": 10.0}}
        params["/telex_b/cameras/cameras"] = {"mast": {"zoom_max": 4.0}}
        finder = {"topic": "/telex/range_finder", "frame": "tip", "min": 0.1, "max": 4.0}
        params["equipment"] = {"range_finder": finder}
        params["/telex_b/equipment"] = {"microphone": {"frame": "mic"}}
        params["/telex_b/training_aids"] = {"pads": {"topic": "/telex_b/sim/gripper_contact"}}
        async with bench.served() as http:
            for robot, camera, most in (("telex", "head", 10.0), ("telex_b", "mast", 4.0)):
                told = await (await http.get(f"/robot.json?robot={robot}")).json()
                assert told["cameras"] == {camera: {"zoom_max": most}}
                assert told["equipment"] == params[_of(robot, "equipment")]
                assert told["training_aids"] == params.get(_of(robot, "training_aids"), {})
            own = await (await http.get("/config.json")).json()
            other = await (await http.get("/config.json?robot=telex_b")).json()
            same = await (await http.get("/config.json?robot=telex")).json()
            assert own == same
            assert (own["namespace"], own["rosbridge"]) == ("/telex", "ws://127.0.0.1:9090")
            assert (other["namespace"], other["rosbridge"]) == ("/telex_b", "ws://127.0.0.1:9091")
            assert other["cameras"] == [{"name": "front", "topic": OTHER}]
            assert own["robots"] == [
                {"name": "telex", "rosbridge": "ws://127.0.0.1:9090"},
                {"name": "telex_b", "rosbridge": "ws://127.0.0.1:9091"},
            ]
            assert (own["simulator"], other["simulator"]) == ("/telex", "/telex")

    run(check())


def test_a_robot_that_is_not_there_is_named(bench):
    async def check():
        async with bench.served() as http:
            for path in ("/", "/instructor", "/config.json", "/robot.json", "/streams", "/video"):
                async with http.get(f"{path}?robot=husky") as reply:
                    assert reply.status == 404
                    assert "husky&#x27; here; there are: telex, telex_b." in await reply.text()
            for robot in ("telex", "telex_b"):
                assert (await http.get(f"/?robot={robot}")).status == 200

    run(check())


def test_all_cameras_of_the_robot_come_over_one_socket(bench):
    async def check():
        async with bench.served() as http:
            for query, topic in (("", OWN), ("?robot=telex_b", OTHER)):
                async with http.ws_connect(f"/video{query}") as socket:
                    told = await socket.receive_json(timeout=HUNG)
                    assert told["cameras"] == [{"name": "front", "topic": topic}]
                text = await (await http.get(f"/streams{query}")).text()
                assert [each in text for each in (OWN, OTHER)] == [topic == OWN, topic == OTHER]

    run(check())


def test_an_exam_of_one_robot_closes_nothing_of_the_other(bench):
    async def check():
        own, other = bench.server.robots.values()
        async with bench.served() as http:
            other.gate.hear_of_exam("t1")
            assert await bench.snapshot(http, HIDDEN, "&role=instructor") == 403
            assert await bench.snapshot(http, OTHER) == 200
            other.gate.hear_of_exam("")
            own.gate.hear_of_exam("t2")
            assert await bench.snapshot(http, HIDDEN, "&role=instructor") == 200
            assert await bench.snapshot(http, HIDDEN) == 403

    run(check())


def test_the_line_of_a_robot_holds_back_its_own_pictures(bench):
    async def check():
        own, other = bench.server.robots.values()
        other.line.configure(LineFields(loss=1.0, delay=0.1), 0.0)
        async with bench.served() as http:
            assert await bench.snapshot(http, OWN) == 200
            assert own.line.fields != other.line.fields

    run(check())


def test_the_tokens_of_a_robots_bridge_open_its_pictures(bench, tmp_path):
    tokens(bench, tmp_path)

    async def check():
        async with bench.served() as http:
            for token, allowed in (("telex-t", OWN), ("telex_b-t", OTHER)):
                for topic in (OWN, OTHER):
                    got = await bench.snapshot(http, topic, f"&token={token}")
                    assert got == (200 if topic == allowed else 401)
            robots = (("telex", "telex-t"), ("telex_b", "telex_b-t"))
            for robot, _ in robots:
                for of, token in robots:
                    async with http.get(f"/video?robot={robot}&token={token}") as reply:
                        assert reply.status == (426 if of == robot else 401)

    run(check())


@pytest.mark.parametrize("robots", [["a/b"], ["b", "b"], [""], [3]])
def test_names_that_are_none_are_refused(robots):
    with pytest.raises(ConfigError, match="robots"):
        read_config(VideoServerConfig, {"robots": robots}, "~")
