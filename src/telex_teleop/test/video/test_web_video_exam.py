"""Pictures and pages of other processes while an exam runs: what the list leaves open, and when."""

from __future__ import annotations

import asyncio
import contextlib

import aiohttp
import pytest
from aiohttp import web
from sample_pictures import jpeg
from waiting import wait_until_async
from web_fakes import HUNG, HUNG_TEST, FakePictures, served

from telex_control.common.params import ConfigError
from telex_teleop.web.server_config import VideoServerConfig
from telex_teleop.web.video.pictures import CompressedPicture
from telex_teleop.web.video.video_server_app import VideoServer

FRONT, REAR, OVERVIEW, REPLAYED = (
    f"/telex/{name}/image_raw"
    for name in ("cameras/front", "cameras/rear", "cameras/overview", "replay/cameras/outside")
)
TEACHER = "role=instructor&token=teacher"
TRIAL = "t1"
LIST = "subscribe: [cameras/front/*]\npages: [/training/api/brief/*]\n"
"""Narrower than the shipped one."""


class Bench:
    def __init__(self, tmp_path, rights=""):
        (tmp_path / "token").write_text("teacher")
        (tmp_path / "token").chmod(0o600)
        topics = (FRONT, REAR, OVERVIEW, REPLAYED)
        self.pictures = FakePictures(
            {f"{topic}/compressed": "sensor_msgs/CompressedImage" for topic in topics}
        )
        self.pictures.params.update(
            {
                "rosbridge/instructor_token_file": str(tmp_path / "token"),
                "rosbridge/exam_rights": rights,
            }
        )
        self.console = tmp_path
        handler = web.Application()
        handler.router.add_route("*", "/{path:.*}", self._tell)
        self.handler = handler

    async def _tell(self, request):
        return web.Response(text=f"page {request.path}")

    @contextlib.asynccontextmanager
    async def served(self):
        self.server = VideoServer(
            VideoServerConfig(), self.pictures, "/telex/", self.console, lambda _: None
        )
        async with served(self.handler) as pages:
            for name in ("training", "replay", "progress"):
                self.pictures.params[f"~mounts/{name}"] = {"handler": pages}
            async with served(self.server.make_app()) as url, aiohttp.ClientSession(url) as http:
                yield http

    async def feed(self, topic):
        name = f"{topic}/compressed"
        await wait_until_async(lambda: name in self.pictures.receivers)
        self.pictures.feed(name, CompressedPicture(1.0, jpeg(), 1.0))


def run(coroutine):
    asyncio.run(asyncio.wait_for(coroutine, HUNG_TEST))


async def status(http, address, **options):
    async with http.get(address, **options) as reply:
        return reply.status


async def until_it_ends(stream):
    while await stream.content.read(65536):
        pass


def test_streams_that_are_not_on_the_list_are_cut_and_others_go_on(tmp_path):
    bench = Bench(tmp_path)

    async def check():
        async with bench.served() as http:
            kept = await http.get(f"/stream?topic={FRONT}")
            cut = await http.get(f"/stream?topic={REPLAYED}")
            teachers = await http.get(f"/stream?topic={REPLAYED}&{TEACHER}")
            asked = asyncio.ensure_future(http.get(f"/snapshot?topic={REPLAYED}"))
            await wait_until_async(lambda: len(bench.pictures.receivers) == 2)
            await asyncio.sleep(0.05)
            bench.server.hear_of_exam(TRIAL)
            with contextlib.suppress(aiohttp.ClientError):
                await asyncio.wait_for(until_it_ends(cut), HUNG)
            for topic in (REPLAYED, FRONT):
                await bench.feed(topic)
            assert (await asked).status == 403
            for stream in (kept, teachers):
                assert b"X-Timestamp" in await asyncio.wait_for(stream.content.read(900), HUNG)
            for path in ("stream", "snapshot", "stream_viewer"):
                for topic in (REPLAYED, OVERVIEW):
                    assert await status(http, f"/{path}?topic={topic}") == 403
            assert await status(http, f"/stream_viewer?topic={FRONT}") == 200
            assert await status(http, f"/stream_viewer?topic={REPLAYED}&{TEACHER}") == 200
            async with http.get("/streams") as reply:
                listed = await reply.text()
            assert FRONT in listed
            assert REPLAYED not in listed
            bench.server.hear_of_exam("")
            assert await status(http, f"/stream_viewer?topic={REPLAYED}") == 200

    run(check())


def test_views_of_the_websocket_end_and_come_back(tmp_path):
    (tmp_path / "list.yaml").write_text(LIST)
    bench = Bench(tmp_path, str(tmp_path / "list.yaml"))
    rear = f"{REAR}/compressed"

    async def check():
        async with bench.served() as http, http.ws_connect("/video") as socket:
            await socket.receive_json(timeout=HUNG)
            await socket.send_json({"show": [{"camera": "front"}, {"camera": "rear"}]})
            await wait_until_async(lambda: len(bench.pictures.receivers) == 2)
            bench.server.hear_of_exam(TRIAL)
            await wait_until_async(lambda: rear not in bench.pictures.receivers)
            await socket.send_json({"show": [{"camera": "rear"}]})
            assert 'no camera "rear"' in (await socket.receive_json(timeout=HUNG))["error"]
            assert list(bench.pictures.receivers) == [f"{FRONT}/compressed"]
            async with http.ws_connect("/video") as other:
                await other.receive_json(timeout=HUNG)
                await other.send_json({"show": [{"camera": "rear"}]})
                assert "error" in await other.receive_json(timeout=HUNG)
            bench.server.hear_of_exam("")
            await wait_until_async(lambda: rear in bench.pictures.receivers)

    run(check())


@pytest.mark.parametrize("known", ["topic", "parameter"])
def test_pages_are_those_of_the_list_for_all_but_the_token(tmp_path, known):
    bench = Bench(tmp_path)
    if known == "parameter":  # the exam began before this server
        bench.pictures.params["rosbridge/exam"] = TRIAL

    async def check():
        async with bench.served() as http:
            if known == "topic":
                assert await status(http, "/replay/t0") == 200
                bench.server.hear_of_exam(TRIAL)
            for path in (
                *("/replay/t0", "/replay/api/picture/t0?time=1", "/progress/", "/progress/?name=x"),
                *("/training/api/sheets", "/training/api/sheet/t0?name=ann", "/training/x"),
                *("/training/api/workload/t0", "/training/api/brief/%2e%2e/sheet/t0"),
                *("/training//api/sheets", "/training/api/brief/..%2fsheets"),
            ):
                assert await status(http, path) in (403, 404), path
                assert (await http.post(path)).status in (403, 404, 405), path
                for claim in ("role=instructor", "role=instructor&token=guess"):
                    joint = "&" if "?" in path else "?"
                    assert await status(http, f"{path}{joint}{claim}") in (401, 403, 404)
            assert await status(http, f"/training/api/brief/{TRIAL}?name=ann") == 200
            assert await status(http, f"/training/api/goal/{TRIAL}.jpg") == 200
            assert await status(http, f"/replay/t0?{TEACHER}") == 200
            bench.server.hear_of_exam("")
            assert await status(http, "/progress/") == 200

    run(check())


def test_a_parameter_that_is_read_late_does_not_bring_an_exam_back(tmp_path):
    bench = Bench(tmp_path)
    bench.pictures.params["rosbridge/exam"] = TRIAL

    async def check():
        async with bench.served() as http:
            bench.server.hear_of_exam("")
            assert await status(http, "/progress/") == 200

    run(check())


def test_without_an_instructors_token_nobody_is_one_during_an_exam(tmp_path):
    bench = Bench(tmp_path)
    del bench.pictures.params["rosbridge/instructor_token_file"]

    async def check():
        async with bench.served() as http:
            assert await status(http, f"/stream_viewer?topic={OVERVIEW}&role=instructor") == 200
            bench.server.hear_of_exam(TRIAL)
            assert await status(http, f"/stream_viewer?topic={OVERVIEW}&role=instructor") == 403

    run(check())


def test_the_robots_description_is_told_in_an_exam_to_who_may_see_pictures(tmp_path):
    bench = Bench(tmp_path)

    async def check():
        async with bench.served() as http:
            assert await status(http, "/robot.urdf") == 204  # there is none yet
            bench.pictures.params["robot_description"] = "<robot name='telex'/>"
            bench.server.hear_of_exam(TRIAL)
            async with http.get("/robot.urdf") as reply:
                assert (await reply.text(), reply.content_type) == (
                    "<robot name='telex'/>",
                    "application/xml",
                )
            assert await status(http, "/robot.urdf?robot=husky") == 404
            (tmp_path / "clients").write_text("sesame")
            (tmp_path / "clients").chmod(0o600)
            bench.pictures.params["rosbridge/token_file"] = str(tmp_path / "clients")
            assert await status(http, "/robot.urdf") == 401
            assert await status(http, "/robot.urdf?token=sesame") == 200

    run(check())


def test_a_list_that_cannot_be_read_ends_the_server(tmp_path):
    bench = Bench(tmp_path, str(tmp_path / "none.yaml"))

    async def check():
        with pytest.raises(ConfigError, match=r"none\.yaml: cannot be read"):
            async with bench.served():
                pass

    run(check())
