"""The line before the video server: pictures come as late as their stamps say."""

from __future__ import annotations

import asyncio
import contextlib
import struct

import aiohttp
from sample_pictures import jpeg
from waiting import wait_until_async
from web_fakes import HUNG, FakePictures, on_loop, served

from telex_teleop.web.line.fields import PERFECT, LineFields
from telex_teleop.web.server_config import VideoServerConfig
from telex_teleop.web.video.pictures import CompressedPicture
from telex_teleop.web.video.video_server_app import VideoServer

FRONT, REAR = (f"/telex/cameras/{name}/image_raw/compressed" for name in ("front", "rear"))
BEGUN = 100.0


class Bench:
    """A video server whose sim time a test moves on, on a line with a delay of 0.5 s."""

    def __init__(self, url, http, server, pictures):
        self.url, self.http, self.server, self.pictures = url, http, server, pictures

    def set_line(self, **fields):
        self.server.line.configure(LineFields(**fields) if fields else PERFECT, BEGUN)

    def go_to(self, moment):
        self.pictures.time = BEGUN + moment

    async def feed(self, quality, stamp, topic=FRONT):
        """Publish a picture with a stamp, now by sim time."""
        await wait_until_async(lambda: topic in self.pictures.receivers)
        picture = CompressedPicture(BEGUN + stamp, jpeg(quality), BEGUN + stamp)
        thread = self.pictures.feed(topic, picture)
        await asyncio.get_running_loop().run_in_executor(None, thread.join)
        await asyncio.sleep(0.02)

    @contextlib.asynccontextmanager
    async def watching(self, query=""):
        """Connect, and watch the front camera as if that had been asked for long ago."""
        fields = self.server.line.fields
        self.set_line()
        async with self.http.ws_connect(f"{self.url}/video{query}") as socket:
            await socket.receive_json(timeout=HUNG)
            await socket.send_json({"show": [{"camera": "front", "credits": 8}]})
            await wait_until_async(lambda: FRONT in self.pictures.receivers)
            self.server.line.configure(fields, BEGUN)
            yield socket


@contextlib.asynccontextmanager
async def bench(tmp_path, **config):
    pictures = FakePictures(dict.fromkeys((FRONT, REAR), "sensor_msgs/CompressedImage"))
    pictures.time = BEGUN
    server = VideoServer(VideoServerConfig(**config), pictures, "/telex/", tmp_path, print)
    async with served(server.make_app()) as url, aiohttp.ClientSession() as http:
        made = Bench(url, http, server, pictures)
        made.set_line(delay=0.5)
        yield made


async def stamp_of(socket):
    """Return when the next picture was taken (s since the beginning)."""
    data = await socket.receive_bytes(timeout=HUNG)
    return round(struct.unpack("<BBHId", data[:16])[4] - BEGUN, 3)


async def nothing_comes(socket, period=0.25):
    await asyncio.sleep(period)
    await socket.send_json({"ping": 1})
    assert "pong" in await socket.receive_json(timeout=HUNG)


def on_bench(check, **config):
    """Make a test of a coroutine function that gets a bench."""

    def test(tmp_path):
        @on_loop
        async def run():
            async with bench(tmp_path, **config) as made:
                await check(made)

        run()

    test.__doc__ = check.__doc__
    return test


@on_bench
async def test_pictures_come_when_their_stamps_are_old_enough_and_keep_them(bench):
    async with bench.watching() as socket:
        bench.go_to(0.5)
        await bench.feed(80, stamp=0.45)
        await bench.feed(81, stamp=0.48)
        bench.go_to(0.94)
        await nothing_comes(socket)
        bench.go_to(0.951)
        assert await stamp_of(socket) == 0.45
        await nothing_comes(socket)
        bench.go_to(1.0)
        assert await stamp_of(socket) == 0.48


@on_bench
async def test_instructors_and_a_perfect_line_have_no_delay(bench):
    async with bench.watching("?role=instructor") as socket:
        await bench.feed(80, stamp=0.0)
        assert await stamp_of(socket) == 0.0
    bench.set_line()
    async with bench.watching() as socket:
        await bench.feed(80, stamp=0.0)
        assert await stamp_of(socket) == 0.0


@on_bench
async def test_another_view_passes_the_line_too(bench):
    async with bench.watching() as socket:
        bench.go_to(0.5)
        await bench.feed(80, stamp=0.5)
        await socket.send_json({"show": [{"camera": "rear", "credits": 8}]})
        await nothing_comes(socket, 0.0)
        bench.go_to(0.9)
        await socket.send_json({"show": [{"camera": "moon"}]})
        await nothing_comes(socket)
        assert REAR not in bench.pictures.receivers
        bench.go_to(1.0)
        assert await stamp_of(socket) == 0.5
        await wait_until_async(lambda: REAR in bench.pictures.receivers)
        bench.go_to(1.5)
        assert "no camera" in (await socket.receive_json(timeout=HUNG))["error"]


@on_bench
async def test_an_outage_shows_the_newest_picture_at_its_end(bench):
    async with bench.watching() as socket:
        bench.set_line(outage_every=10.0, outage_for=5.0)
        bench.go_to(6.0)
        for step in range(3):
            await bench.feed(80, stamp=6.0 + 0.01 * step)
        await nothing_comes(socket)
        bench.go_to(10.1)
        assert await stamp_of(socket) == 6.02
        await nothing_comes(socket)


@on_bench
async def test_streams_and_snapshots_are_late_as_well(bench):
    async def snapshot():
        async with bench.http.get(f"{bench.url}/snapshot?topic={FRONT}") as response:
            return response.status, response.headers.get("X-Timestamp")

    taking = asyncio.ensure_future(snapshot())
    await bench.feed(80, stamp=0.0)
    bench.go_to(0.45)
    await asyncio.sleep(0.2)
    assert not taking.done()
    bench.go_to(0.5)
    assert await taking == (200, "100.000000")
    async with bench.http.get(f"{bench.url}/stream?topic={FRONT}") as response:
        await bench.feed(80, stamp=0.5)
        reading = asyncio.ensure_future(response.content.readuntil(b"X-Timestamp: 100.500000"))
        bench.go_to(0.9)
        await asyncio.sleep(0.2)
        assert not reading.done()
        bench.go_to(1.0)
        await asyncio.wait_for(reading, HUNG)


def test_a_snapshot_shows_nothing_that_an_outage_holds(tmp_path):
    async def check(bench):
        bench.set_line(loss=1.0)
        async with bench.watching("?role=instructor"):
            asking = asyncio.ensure_future(bench.http.get(f"{bench.url}/snapshot?topic={FRONT}"))
            await bench.feed(80, stamp=0.0)
            assert (await asking).status == 504

    on_bench(check, snapshot_timeout=0.4)(tmp_path)
