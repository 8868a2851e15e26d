"""The video server over HTTP, fed by hand."""

from __future__ import annotations

import asyncio
import contextlib
import html
import json
import socket
import time

import aiohttp
import pytest
import simplejpeg
from sample_pictures import jpeg, raw, two_halves
from waiting import wait_until_async
from web_fakes import FakePictures, served

from telex_teleop.web.server_config import VideoServerConfig
from telex_teleop.web.video import video_server_app as video_app
from telex_teleop.web.video.pictures import CompressedPicture
from telex_teleop.web.video.video_server_app import VideoServer

pytestmark = [pytest.mark.real_time, pytest.mark.waiting]

CAMERA = "/telex/cameras/front/image_raw"
COMPRESSED = f"{CAMERA}/compressed"


class Bench:
    """A video server with one camera, and a console of one page."""

    def __init__(self, tmp_path, **config):
        self.pictures = FakePictures(
            {
                CAMERA: "sensor_msgs/Image",
                COMPRESSED: "sensor_msgs/CompressedImage",
                "/raw": "sensor_msgs/Image",
            }
        )
        self.warnings = []
        (tmp_path / "index.html").write_text("<title>console</title>")
        (tmp_path / "main.js").write_text("start();")
        self.server_config = VideoServerConfig(**config)
        self.console = tmp_path

    def bridge_has(self, **paths):
        """Set parameters of the bridge."""
        self.pictures.params.update({f"rosbridge/{name}": path for name, path in paths.items()})

    def served(self):
        self.server = VideoServer(
            self.server_config, self.pictures, "/telex/", self.console, self.warnings.append
        )
        return served(self.server.make_app())

    async def feed(self, data, topic=COMPRESSED, stamp=1.25):
        await wait_until_async(lambda: topic in self.pictures.receivers)
        self.pictures.feed(topic, CompressedPicture(stamp, data))


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)


def run(coroutine):
    asyncio.run(asyncio.wait_for(coroutine, 20.0))


class Stream:
    """A client of a stream that reads the bytes as they are."""

    def __init__(self, url, target, receive_buffer=None):
        host, port = url[len("http://") :].split(":")
        self.socket = socket.socket()
        if receive_buffer is not None:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.socket.connect((host, int(port)))
        self.socket.sendall(f"GET {target} HTTP/1.1\r\nHost: {host}\r\n\r\n".encode())
        self.socket.setblocking(False)
        self.bytes = b""

    async def until(self, end, timeout=5.0):
        """Return all that came up to the end of some bytes."""
        loop = asyncio.get_running_loop()
        while end not in self.bytes:
            chunk = await asyncio.wait_for(loop.sock_recv(self.socket, 65536), timeout)
            assert chunk, f"the stream ended after {self.bytes!r}"
            self.bytes += chunk
        head, found, self.bytes = self.bytes.partition(end)
        return head + found

    async def part(self):
        """Return headers and data of the next part."""
        head = (await self.until(b"\r\n\r\n")).decode()
        headers = dict(line.split(": ", 1) for line in head.strip().split("\r\n"))
        tail = b"\r\n--boundarydonotcross\r\n"
        body = await self.until(tail)
        data = body[: -len(tail)]
        while len(data) < int(headers["Content-Length"]):
            data = body + (await self.until(tail))[: -len(tail)]
        return headers, data

    async def ended(self):
        loop = asyncio.get_running_loop()
        while await asyncio.wait_for(loop.sock_recv(self.socket, 65536), 5.0):
            pass


def test_a_stream_hands_on_pictures_unchanged(bench):
    async def check():
        async with bench.served() as url:
            client = Stream(url, f"/stream?topic={CAMERA}")
            head = (await client.until(b"--boundarydonotcross\r\n")).decode()
            assert head.startswith("HTTP/1.0 200 OK\r\n")
            assert "multipart/x-mixed-replace;boundary=boundarydonotcross" in head
            for quality in (90, 80):
                await bench.feed(jpeg(quality), stamp=quality)
                headers, data = await client.part()
                assert data == jpeg(quality)
                assert headers["X-Timestamp"] == f"{quality}.000000"
                assert headers["Content-type"] == "image/jpeg"
            client.socket.close()

    run(check())


def test_subscriptions_last_from_the_first_client_to_the_last(bench):
    async def check():
        async with bench.served() as url:
            assert bench.pictures.events == []
            first = Stream(url, f"/stream?topic={CAMERA}")
            await wait_until_async(lambda: bench.pictures.events == [("subscribe", COMPRESSED)])
            second = Stream(url, "/stream?topic=cameras/front/image_raw&width=32")
            await second.until(b"--boundarydonotcross\r\n")
            first.socket.close()
            await bench.feed(jpeg())
            _, data = await second.part()
            assert simplejpeg.decode_jpeg_header(data)[:2] == (48, 32)
            assert len(bench.pictures.events) == 1
            second.socket.close()
            await wait_until_async(lambda: bench.pictures.events[-1] == ("unsubscribe", COMPRESSED))
            assert len(bench.server.hubs) == 0
            third = Stream(url, f"/stream?topic={CAMERA}")
            await wait_until_async(lambda: len(bench.pictures.events) == 3)
            third.socket.close()

    run(check())


def test_a_new_client_sees_the_last_picture_at_once_in_its_own_variant(bench):
    async def check():
        async with bench.served() as url:
            clients = [Stream(url, f"/stream?topic={CAMERA}")]
            await bench.feed(jpeg())
            await clients[0].until(b"--boundarydonotcross\r\n")
            await clients[0].part()
            for target, width in (("", 64), ("&width=32", 32), ("&width=32", 32)):
                clients.append(Stream(url, f"/stream?topic={CAMERA}{target}"))
                await clients[-1].until(b"--boundarydonotcross\r\n")
                _, data = await clients[-1].part()
                assert simplejpeg.decode_jpeg_header(data)[1] == width
            for client in clients:
                client.socket.close()

    run(check())


def test_each_variant_is_encoded_once_for_all_its_clients(bench, monkeypatch):
    encode, encoded = video_app.encode, []

    def count(picture, variant, quality):
        encoded.append(variant)
        return encode(picture, variant, quality)

    monkeypatch.setattr(video_app, "encode", count)

    async def check():
        async with bench.served() as url:
            targets = ["&width=32"] * 3 + ["&quality=50"] * 2
            clients = [Stream(url, f"/stream?topic=/raw{target}") for target in targets]
            for client in clients:
                await client.until(b"--boundarydonotcross\r\n")
            await wait_until_async(lambda: "/raw" in bench.pictures.receivers)
            bench.pictures.feed("/raw", raw("rgb8", two_halves()))
            for client in clients:
                await client.part()
                client.socket.close()
            assert len(encoded) == 2

    run(check())


def test_a_stalled_client_delays_nobody_and_gets_fresh_pictures_afterwards(tmp_path):
    bench = Bench(tmp_path, send_buffer=4096)
    pictures = [jpeg()[:-2] + bytes([number]) * 20000 + b"\xff\xd9" for number in range(60)]

    async def check():
        async with bench.served() as url:
            stalled = Stream(url, f"/stream?topic={CAMERA}", receive_buffer=4096)
            reader = Stream(url, f"/stream?topic={CAMERA}")
            await reader.until(b"--boundarydonotcross\r\n")
            await wait_until_async(lambda: COMPRESSED in bench.pictures.receivers)
            for number, data in enumerate(pictures):
                await bench.feed(data, stamp=number)
                headers, received = await reader.part()
                assert received == data
            viewers = [v for hub in bench.server.hubs._hubs.values() for v in hub.viewers]
            buffered = [late._viewer._backlog.buffered() for late in viewers]
            assert len(buffered) == 2
            assert max(buffered) <= len(pictures[0]) + 500
            await stalled.until(b"--boundarydonotcross\r\n")
            stamps = []
            while not stamps or stamps[-1] < len(pictures):
                await bench.feed(jpeg(), stamp=len(pictures) + len(stamps))
                headers, _ = await stalled.part()
                stamps.append(float(headers["X-Timestamp"]))
            stale = [stamp for stamp in stamps if stamp < len(pictures)]
            assert len(stale) <= 3
            stalled.socket.close()
            reader.socket.close()

    run(check())


def test_a_client_that_takes_nothing_is_dropped_after_a_while(tmp_path, monkeypatch):
    monkeypatch.setattr(video_app, "CHECK_PERIOD", 0.05)
    bench = Bench(tmp_path, send_buffer=4096, stall_timeout=0.5)

    async def check():
        async with bench.served() as url:
            stalled = Stream(url, f"/stream?topic={CAMERA}", receive_buffer=4096)
            await bench.feed(jpeg()[:-2] + bytes(2000000) + b"\xff\xd9")
            assert len(bench.server.hubs) == 1
            await wait_until_async(lambda: len(bench.server.hubs) == 0)
            stalled.socket.close()

    run(check())


def test_unusable_pictures_are_skipped_with_a_warning(bench):
    async def check():
        async with bench.served() as url:
            client = Stream(url, f"/stream?topic={CAMERA}")
            await client.until(b"--boundarydonotcross\r\n")
            await bench.feed(b"nonsense")
            await wait_until_async(lambda: bench.warnings)
            assert bench.warnings[0] == (
                f"dropped a picture of {COMPRESSED}: it is neither JPEG nor PNG"
            )
            await bench.feed(jpeg())
            assert (await client.part())[1] == jpeg()
            client.socket.close()

    run(check())


def test_the_servers_end_ends_open_streams_at_once(bench):
    async def check():
        async with bench.served() as url:
            client = Stream(url, f"/stream?topic={CAMERA}")
            await client.until(b"--boundarydonotcross\r\n")
            ends = time.monotonic()
        # aiohttp by itself would wait longer for the stream's end
        assert time.monotonic() - ends < 5.0
        with contextlib.suppress(ConnectionResetError):
            await client.ended()
        client.socket.close()

    run(check())


def test_snapshot_is_the_next_picture(bench):
    async def check():
        async with bench.served() as url, aiohttp.ClientSession() as http:
            asked = asyncio.ensure_future(http.get(f"{url}/snapshot?topic=/raw&width=32"))
            await wait_until_async(lambda: "/raw" in bench.pictures.receivers)
            bench.pictures.feed("/raw", raw("rgb8", two_halves()))
            reply = await asked
            assert (reply.status, reply.content_type) == (200, "image/jpeg")
            assert reply.headers["X-Timestamp"] == "1.500000"
            assert reply.headers["Access-Control-Allow-Origin"] == "*"
            assert simplejpeg.decode_jpeg_header(await reply.read())[:2] == (48, 32)
            await wait_until_async(lambda: bench.pictures.events[-1] == ("unsubscribe", "/raw"))

    run(check())


def test_snapshot_of_a_silent_topic_says_so_and_of_a_latched_one_repeats(tmp_path):
    bench = Bench(tmp_path, snapshot_timeout=0.2)

    async def check():
        async with bench.served() as url, aiohttp.ClientSession() as http:
            reply = await http.get(f"{url}/snapshot?topic={CAMERA}")
            assert reply.status == 504
            assert "within 0.2 s" in await reply.text()
            watcher = Stream(url, f"/stream?topic={CAMERA}")
            await wait_until_async(lambda: len(bench.pictures.events) == 3)
            await bench.feed(jpeg())
            await watcher.until(b"\xff\xd9")
            reply = await http.get(f"{url}/snapshot?topic={CAMERA}")
            assert await reply.read() == jpeg()
            watcher.socket.close()

    run(check())


def test_a_snapshot_of_what_is_watched_has_nothing_made_for_it(bench):
    async def check():
        async with bench.served() as url, aiohttp.ClientSession() as http:
            address = f"{url}/snapshot?watched&topic=cameras/front/image_raw"
            assert (await http.get(address)).status == 404
            assert bench.pictures.events == []
            watcher = Stream(url, f"/stream?topic={CAMERA}")
            await bench.feed(jpeg())
            await watcher.until(b"\xff\xd9")
            reply = await http.get(address)
            assert (reply.status, await reply.read()) == (200, jpeg())
            assert (await http.get(f"{address}&width=16")).status == 404
            assert (await http.get(f"{url}/snapshot?watched&topic={CAMERA}x")).status == 404
            assert [event for event in bench.pictures.events if event[0] == "unsubscribe"] == []
            watcher.socket.close()

    run(check())


def test_of_a_watched_camera_the_small_picture_is_taken(bench):
    preview = "/telex/cameras/front/preview/compressed"
    bench.pictures.published[preview] = "sensor_msgs/CompressedImage"

    async def check():
        async with bench.served() as url, aiohttp.ClientSession() as http:
            small = jpeg(quality=50)
            watchers = [Stream(url, f"/stream?topic={name}") for name in (CAMERA, preview)]
            await bench.feed(jpeg())
            await bench.feed(small, preview)
            for watcher in watchers:
                await watcher.until(b"\xff\xd9")
            reply = await http.get(f"{url}/snapshot?watched&topic={CAMERA}")
            assert await reply.read() == small
            for watcher in watchers:
                watcher.socket.close()

    run(check())


def test_what_operators_may_not_watch_is_not_shown_to_them_either(tmp_path):
    bench = Bench(tmp_path, hidden_cameras=("front",))

    async def check():
        async with bench.served() as url, aiohttp.ClientSession() as http:
            watcher = Stream(url, f"/stream?topic={CAMERA}&role=instructor")
            await bench.feed(jpeg())
            await watcher.until(b"\xff\xd9")
            address = f"{url}/snapshot?watched&topic={CAMERA}"
            assert (await http.get(address)).status == 403
            assert (await http.get(f"{address}&role=instructor")).status == 200
            watcher.socket.close()

    run(check())


@pytest.mark.parametrize("path", ["stream", "snapshot", "stream_viewer"])
@pytest.mark.parametrize(
    ("asked", "status", "said"),
    [
        ("", 400, "The parameter &#x27;topic&#x27; is missing"),
        ("topic=/none", 404, "No image topic &#x27;/none&#x27; is published; /streams lists"),
        ("topic=%3Cscript%3E", 404, "&lt;script&gt;"),
        ("topic=/raw&default_transport=theora", 400, "must be raw or compressed"),
        ("topic=/raw&width=x", 400, "must be an integer from 1 to 1920 (pixels)"),
    ],
)
def test_requests_that_cannot_be_served_are_answered_with_a_sentence(
    bench, path, asked, status, said
):
    async def check():
        async with bench.served() as url, aiohttp.ClientSession() as http:
            reply = await http.get(f"{url}/{path}?{asked}")
            text = await reply.text()
            assert reply.status == status
            assert said in text
            assert "<script" not in text
            assert bench.pictures.events == []

    run(check())


def test_pages(bench):
    async def check():
        async with bench.served() as url, aiohttp.ClientSession() as http:
            viewer = await (await http.get(f"{url}/stream_viewer?topic=/raw&width=32")).text()
            assert '<img src="/stream?topic=%2Fraw&amp;width=32"' in viewer
            index = await (await http.get(f"{url}/streams")).text()
            assert f"/stream_viewer?topic={CAMERA}" in index
            console = await http.get(f"{url}/")
            assert await console.text() == "<title>console</title>"
            assert console.headers["Cache-Control"] == "no-cache"
            assert "default-src 'self'" in console.headers["Content-Security-Policy"]
            script = await http.get(f"{url}/main.js")
            assert "javascript" in script.content_type
            too_long = "/" + "x" * 5000
            for missing in ("/no.html", "/%2e%2e/secret", "/..%2fsecret", "/%00", too_long, "//"):
                reply = await http.get(aiohttp.client.URL(f"{url}{missing}", encoded=True))
                assert reply.status == 404
                assert "404 Not Found" in await reply.text()
            assert (await http.post(f"{url}/stream?topic=/raw")).status == 405
            assert (await http.head(f"{url}/stream?topic=/raw")).status == 405
            assert (await http.get(f"{url}/stream?topic=/raw&type=vp8")).status == 404
            assert (await http.get(f"{url}/video")).status == 426
            assert (await http.head(f"{url}/")).status == 200
            assert bench.pictures.events == []

    run(check())


def test_the_console_is_told_where_everything_is(bench):
    async def check():
        async with bench.served() as url, aiohttp.ClientSession() as http:
            reply = await http.get(f"{url}/config.json")
            assert reply.headers["Access-Control-Allow-Origin"] == "*"
            config = await reply.json()
            assert config == {
                "namespace": "/telex",
                "rosbridge": None,
                "cameras": [{"name": "front", "topic": CAMERA}],
                "hidden_cameras": ["overview"],
                "main_camera": "front",
                "main_rate": 30.0,
                "thumbnail_rate": 10.0,
                "thumbnail_width": 320,
            }
            bench.pictures.params["rosbridge/url"] = "ws://127.0.0.1:9090"
            for host, told in (
                ("localhost:8080", "ws://127.0.0.1:9090"),
                ("robot.example:8080", "ws://robot.example:9090"),
                ("[2001:db8::1]:8080", "ws://[2001:db8::1]:9090"),
            ):
                reply = await http.get(f"{url}/config.json", headers={"Host": host})
                assert json.loads(await reply.text())["rosbridge"] == told

    run(check())


def test_pages_are_told_which_cameras_zoom(bench):
    async def check():
        async with bench.served() as url, aiohttp.ClientSession() as http:
            nothing = {"cameras": {}, "equipment": {}, "training_aids": {}}
            assert await (await http.get(f"{url}/robot.json")).json() == nothing
            cameras = {"front": {"rate": 25.0}, "head": {"zoom_max": 10.0}, "overview": {}}
            bench.pictures.params["cameras/cameras"] = cameras
            told = await (await http.get(f"{url}/robot.json")).json()
            shown = {"front": {"zoom_max": None}, "head": {"zoom_max": 10.0}}
            assert told == {**nothing, "cameras": shown}

    run(check())


PICTURES = (
    f"stream?topic={CAMERA}",
    f"snapshot?topic={CAMERA}",
    f"stream_viewer?topic={CAMERA}",
    "streams?",
    "video?",
)


async def replies(http, url, access="", **options):
    """Return the statuses of all addresses of pictures."""
    got = []
    for path in PICTURES:
        async with http.get(f"{url}/{path}{access}", **options) as reply:
            got.append(reply.status)
    return got


SEEN, REFUSED = [200, 504, 200, 200, 426], [401] * 5


def token_files(folder, **tokens):
    """Write tokens to files; return the parameters that name them."""
    for name, token in tokens.items():
        (folder / name).write_text(token)
        (folder / name).chmod(0o600)
    return {f"{name}_file": str(folder / name) for name in tokens}


@pytest.mark.parametrize("given_to", ["this server", "the bridge"])
def test_where_there_is_a_token_pictures_need_it(tmp_path, given_to):
    files = token_files(tmp_path, token="sesame", instructor_token="teacher")
    bench = Bench(tmp_path, snapshot_timeout=0.1, **(files if given_to == "this server" else {}))
    if given_to == "the bridge":
        bench.bridge_has(**files)

    async def check():
        async with bench.served() as url, aiohttp.ClientSession() as http:
            for access in ("", "&token=", "&token=wrong", "&role=instructor&token=sesame"):
                assert await replies(http, url, access) == REFUSED
            said = await (await http.get(f"{url}/{PICTURES[0]}")).text()
            assert "This server asks for a token: add ?token=... to its address" in said
            for access in ("&token=sesame", "&token=teacher", "&role=instructor&token=teacher"):
                assert await replies(http, url, access) == SEEN
            bearer = {"Authorization": "Bearer sesame"}
            assert await replies(http, url, headers=bearer) == SEEN
            assert (await http.get(f"{url}/streams?role=king")).status == 400
            for path in ("", "main.js", "config.json"):
                assert (await http.get(f"{url}/{path}")).status == 200
            viewer = await (await http.get(f"{url}/{PICTURES[2]}&token=sesame")).text()
            assert "&amp;token=sesame" in viewer
            index = await (await http.get(f"{url}/streams?token=sesame")).text()
            assert f"/snapshot?topic={CAMERA}&amp;token=sesame" in index

    run(check())


def test_other_machines_see_nothing_as_long_as_there_is_no_token(tmp_path):
    bench = Bench(tmp_path, address="0.0.0.0", snapshot_timeout=0.1)

    async def check():
        async with bench.served() as url, aiohttp.ClientSession() as http:
            assert await replies(http, url, "&token=") == REFUSED
            said = await (await http.get(f"{url}/{PICTURES[0]}")).text()
            assert "set its parameter ~token_file, or start the bridge" in said
            # The bridge starts later, and has made one.
            bench.bridge_has(token_file=str(tmp_path / "token"))
            assert await replies(http, url, "&token=sesame") == REFUSED
            token_files(tmp_path, token="sesame")
            assert await replies(http, url, "&token=sesame") == SEEN
            # Nobody has told an instructor's token, which does not make one of everybody.
            for token in ("", "sesame"):
                assert await replies(http, url, f"&role=instructor&token={token}") == REFUSED
            (tmp_path / "token").chmod(0o644)
            assert await replies(http, url, "&token=sesame") == REFUSED

    run(check())


def test_nobody_sees_anything_while_the_bridges_token_cannot_be_read(tmp_path):
    bench = Bench(tmp_path)
    bench.bridge_has(token_file=str(tmp_path / "gone"))

    async def check():
        async with bench.served() as url, aiohttp.ClientSession() as http:
            assert await replies(http, url) == REFUSED
            said = await (await http.get(f"{url}/{PICTURES[0]}")).text()
            assert "The bridge's token_file" in html.unescape(said)
            assert "is not there" in said

    run(check())


def test_hidden_cameras_are_for_instructors(bench):
    hidden = "/telex/cameras/overview/image_raw"
    others = "/crane/cameras/overview/image_raw"
    bench.pictures.published.update({hidden: "sensor_msgs/Image", others: "sensor_msgs/Image"})

    async def check():
        async with bench.served() as url, aiohttp.ClientSession() as http:
            for topic in (hidden, hidden[1:], "cameras/overview/image_raw", others):
                for path in ("stream", "snapshot", "stream_viewer"):
                    reply = await http.get(f"{url}/{path}?topic={topic}")
                    assert reply.status == 403
                    assert "is for instructors: add role=instructor" in await reply.text()
            for role, seen in (("operator", False), ("instructor", True)):
                access = f"role={role}"
                viewer = await http.get(f"{url}/stream_viewer?topic={hidden}&{access}")
                assert viewer.status == (200 if seen else 403)
                index = await (await http.get(f"{url}/streams?{access}")).text()
                assert ("overview" in index) is seen
                config = await (await http.get(f"{url}/config.json?{access}")).json()
                assert ("overview" in [each["name"] for each in config["cameras"]]) is seen

    run(check())


def test_without_a_master_the_server_says_so(bench):
    async def check():
        bench.pictures.down = True
        async with bench.served() as url, aiohttp.ClientSession() as http:
            for path in ("/streams", "/config.json", "/stream?topic=/raw"):
                reply = await http.get(f"{url}{path}")
                assert reply.status == 503
                assert "The ROS master does not answer" in await reply.text()
            assert (await http.get(f"{url}/")).status == 200

    run(check())
