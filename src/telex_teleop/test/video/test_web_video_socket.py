"""/video: all cameras over one WebSocket, the newest picture only, as the client acknowledges."""

from __future__ import annotations

import asyncio
import contextlib
import struct
import time
import unittest.mock

import aiohttp
import pytest
import simplejpeg
from sample_pictures import jpeg, two_halves
from waiting import wait_until_async
from web_fakes import HUNG, HUNG_TEST, FakePictures, served

from telex_teleop.web.server_config import VideoServerConfig
from telex_teleop.web.video.cameras import CameraList
from telex_teleop.web.video.late.pacer import Pacer
from telex_teleop.web.video.pictures import CompressedPicture
from telex_teleop.web.video.ros_source import captured_at
from telex_teleop.web.video.video_server_app import VideoServer
from telex_teleop.web.video.websocket import messages as protocol
from telex_teleop.web.video.websocket import sockets as video_sockets
from telex_teleop.web.video.websocket.frame_head import binary_frame_head
from telex_teleop.web.video.websocket.messages import Ack, Ping, ProtocolError, Show, WantedView

pytestmark = pytest.mark.slow

FRONT, REAR, OVERVIEW = (
    f"/telex/cameras/{name}/image_raw/compressed" for name in ("front", "rear", "overview")
)
PREVIEW = "/telex/cameras/front/preview/compressed"
COMPRESSED_TYPE = "sensor_msgs/CompressedImage"


# Messages


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"show": []}', Show(())),
        ('{"show": [{"camera": "front"}]}', Show((WantedView("front"),))),
        (
            '{"show": [{"camera": "a", "rate": 2.5, "width": 320, "height": 240, "quality": 50,'
            ' "credits": 2}, {"camera": "b", "rate": null}]}',
            Show((WantedView("a", 2.5, 320, 240, 50, 2), WantedView("b"))),
        ),
        ('{"ack": [3, 4294967295]}', Ack(((3, 4294967295),))),
        ('{"ack": [[3, 5], [0, 6]]}', Ack(((3, 5), (0, 6)))),
        ('{"ping": -1.5}', Ping(-1.5)),
    ],
)
def test_messages_are_read(text, message):
    assert protocol.parse(text, 4096) == message


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "the message is no JSON"),
        ("{", "the message is no JSON"),
        ("[" * 10000, "the message is no JSON"),
        ("null", "the message is null; it must be an object with one key: show, ack or ping"),
        ("{}", "the message is {}; it must be"),
        ('{"show": [], "ping": 1}', "the message is "),
        ('{"play": 1}', 'there is no message "play"; known are show, ack, ping'),
        ('{"show": {}}', "show is {}; it must be a list of views"),
        ('{"show": [1]}', "show[0] is 1; it must be an object with the name of a camera"),
        ('{"show": [{"camera": 0}]}', 'show[0] is {"camera": 0}; it must be'),
        ('{"show": [{"camera": "a", "fps": 1}]}', 'show[0] has "fps"; known are camera, rate'),
        ('{"show": [{"camera": "a"}, {"camera": "a"}]}', 'show has the camera "a" twice'),
        ('{"show": [{"camera": "a", "rate": 0}]}', "show[0].rate is 0; it must be pictures per"),
        ('{"show": [{"camera": "a", "rate": NaN}]}', "show[0].rate is NaN"),
        ('{"show": [{"camera": "a", "rate": true}]}', "show[0].rate is true"),
        ('{"show": [{"camera": "a", "rate": 1e999}]}', "show[0].rate is Infinity"),
        ('{"show": [{"camera": "a", "width": 10.0}]}', "show[0].width is 10.0; it must be an int"),
        ('{"show": [{"camera": "a", "height": 4097}]}', "show[0].height is 4097"),
        ('{"show": [{"camera": "a", "quality": "x"}]}', 'show[0].quality is "x"'),
        ('{"show": [{"camera": "a", "credits": 9}]}', "show[0].credits is 9"),
        ('{"ack": 1}', "ack is 1; it must be a list of a camera's index and the number"),
        ('{"ack": [1, 2, 3]}', "ack is [1, 2, 3]"),
        ('{"ack": []}', "ack is []; it must be a list of a camera's index"),
        ('{"ack": [[1, 2], 3]}', "ack[1] is 3"),
        ('{"ack": [[1, 2], [0, true]]}', "ack[1][1] is true"),
        ('{"ack": [256, 1]}', "ack[0] is 256"),
        ('{"ack": [0, -1]}', "ack[1] is -1"),
        ('{"ping": "now"}', 'ping is "now"; it must be any finite number'),
        ('{"ping": Infinity}', "ping is Infinity"),
        ('{"ping": 1' + "0" * 400 + "}", "ping is 1000"),
        ('{"ping": 1' + "0" * 5000 + "}", ""),  # refused by newer versions of Python's JSON
    ],
)
def test_messages_that_cannot_be_used_are_answered_with_a_sentence(text, said):
    with pytest.raises(ProtocolError) as error:
        protocol.parse(text, 4096)
    assert str(error.value).startswith(said)
    assert len(str(error.value)) < 250


def test_the_header_of_a_picture():
    header = protocol.picture_header(5, 70000, 12.5)
    assert header == b"\x01\x05\x00\x00\x70\x11\x01\x00" + struct.pack("<d", 12.5)


@pytest.mark.parametrize(
    ("length", "head"),
    [
        (16, b"\x82\x10"),
        (125, b"\x82\x7d"),
        (126, b"\x82\x7e\x00\x7e"),
        (65535, b"\x82\x7e\xff\xff"),
        (65536, b"\x82\x7f\x00\x00\x00\x00\x00\x01\x00\x00"),
    ],
)
def test_the_head_of_a_websocket_frame(length, head):
    assert binary_frame_head(length) == head


@pytest.mark.parametrize(
    ("source", "wish", "got"),
    [(25, 10, 10), (30, 25, 25), (10, 10, 10), (5, 10, 5), (30, None, 30)],
)
def test_a_pacer_keeps_the_rate_evenly(source, wish, got):
    pacer, sent = Pacer(wish), []
    for step in range(10 * source):
        # Pictures come up to 4 ms early or late.
        now = step / source + 0.004 * (step % 3 - 1)
        if pacer.is_due(now):
            pacer.sent(now)
            sent.append(now)
    assert len(sent) == pytest.approx(10 * got, abs=2)
    gaps = [b - a for a, b in zip(sent, sent[1:])]
    assert max(gaps) < 1.0 / got + 1.0 / source


def test_cameras_keep_their_index():
    cameras = CameraList("/telex/")
    topics = {REAR: COMPRESSED_TYPE}
    assert cameras.update(topics)
    assert not cameras.update(topics)
    topics = {FRONT: COMPRESSED_TYPE, "/telex/cameras/rear/image_raw": "sensor_msgs/Image"}
    assert cameras.update(topics)
    assert cameras.names == ("rear", "front")
    assert not cameras.find("rear").source.compressed
    assert not cameras.update({})
    many = {f"/telex/cameras/c{n}/image_raw": "sensor_msgs/Image" for n in range(300)}
    assert cameras.update(many)
    assert max(camera.index for camera in map(cameras.find, cameras.names)) == 255


def test_when_a_picture_was_taken_by_the_walls_clock():
    assert captured_at(99.9, 100.0, 5000.0) == pytest.approx(4999.9)
    assert captured_at(100.01, 100.0, 5000.0) == 5000.0  # /clock comes less often than pictures
    assert captured_at(0.0, 100.0, 5000.0) == 5000.0
    assert captured_at(5000.0, 0.0, 5000.0) == 5000.0


# Over a socket


class Bench:
    def __init__(self, tmp_path, **config):
        topics = {FRONT: COMPRESSED_TYPE, REAR: COMPRESSED_TYPE}
        self.pictures = FakePictures(topics)
        self.warnings = []
        self.server = None
        self.config = VideoServerConfig(**config)
        self.console = tmp_path

    @contextlib.asynccontextmanager
    async def connected(self):
        self.server = VideoServer(
            self.config, self.pictures, "/telex/", self.console, self.warnings.append
        )
        async with served(self.server.make_app()) as url, aiohttp.ClientSession() as http:
            self.http, self.url = http, f"{url}/video"
            async with http.ws_connect(self.url) as socket:
                yield Client(socket)

    async def feed(self, topic, data, captured=1.0):
        await wait_until_async(lambda: topic in self.pictures.receivers)
        thread = self.pictures.feed(topic, CompressedPicture(0.5, data, captured))
        await asyncio.get_running_loop().run_in_executor(None, thread.join)
        await asyncio.sleep(0.02)


class Client:
    def __init__(self, socket):
        self.socket = socket

    async def say(self, **message):
        await self.socket.send_json(message)

    async def hear(self):
        return await self.socket.receive_json(timeout=HUNG)

    async def picture(self):
        """Return camera, number, wall time and data of the next message, which is a picture."""
        message = await self.socket.receive_bytes(timeout=HUNG)
        version, camera, flags, number, captured = struct.unpack("<BBHId", message[:16])
        assert (version, flags) == (1, 0)
        return camera, number, captured, message[16:]

    async def ack(self, camera, number):
        await self.say(ack=[camera, number])

    async def nothing_comes(self, period=0.15):
        """A ping that is answered first shows that nothing has been sent before."""
        await asyncio.sleep(period)
        await self.say(ping=1)
        assert "pong" in await self.hear()


def on_bench(check, **config):
    """Make a test of a coroutine function that gets a bench and a client."""

    def test(tmp_path):
        async def run():
            bench = Bench(tmp_path, **config)
            async with bench.connected() as client:
                described = await client.hear()
                assert described["version"] == 1
                names = [camera["name"] for camera in described["cameras"]]
                assert names == ["front", "rear"]
                await check(bench, client)

        asyncio.run(asyncio.wait_for(run(), HUNG_TEST))

    test.__doc__ = check.__doc__
    return test


@on_bench
async def test_pictures_of_several_cameras_come_unchanged(bench, client):
    assert bench.pictures.events == []
    await client.say(show=[{"camera": "rear"}, {"camera": "front"}])
    await bench.feed(FRONT, jpeg(80), captured=7.25)
    await bench.feed(REAR, jpeg(70), captured=8.5)
    first, second = await client.picture(), await client.picture()
    assert (first[0], *first[2:]) == (0, 7.25, jpeg(80))
    assert (second[0], *second[2:]) == (1, 8.5, jpeg(70))
    assert first[1] != second[1]


@on_bench
async def test_a_picture_waits_for_the_acknowledgement_and_is_then_the_newest(bench, client):
    await client.say(show=[{"camera": "front"}])
    for quality in range(60, 70):
        await bench.feed(FRONT, jpeg(quality), captured=quality)
    _, number, captured, _ = await client.picture()
    assert captured == 60
    await client.nothing_comes()
    await client.ack(0, number + 1)  # was never sent
    await client.nothing_comes()
    await client.ack(0, number)
    assert (await client.picture())[2:] == (69, jpeg(69))
    await client.ack(0, number)  # no credit twice
    await bench.feed(FRONT, jpeg())
    await client.nothing_comes()


@on_bench
async def test_more_credits_and_one_acknowledgement_for_all(bench, client):
    await client.say(show=[{"camera": "front", "credits": 3}])
    for count in range(5):
        await bench.feed(FRONT, jpeg(), captured=count)
    pictures = [await client.picture() for _ in range(3)]
    assert [captured for _, _, captured, _ in pictures] == [0, 1, 2]
    await client.nothing_comes()
    await client.ack(0, pictures[2][1])
    assert (await client.picture())[2] == 4
    for count in (5, 6, 7):
        await bench.feed(FRONT, jpeg(), captured=count)
    assert [(await client.picture())[2] for _ in range(2)] == [5, 6]


@on_bench
async def test_a_stalled_camera_does_not_hold_up_another(bench, client):
    await client.say(show=[{"camera": "front"}, {"camera": "rear"}])
    await bench.feed(FRONT, jpeg())
    await client.picture()
    for _ in range(3):
        await bench.feed(FRONT, jpeg())
        await bench.feed(REAR, jpeg())
        camera, number, _, _ = await client.picture()
        assert camera == 1
        await client.ack(camera, number)


@on_bench
async def test_a_box_scales_once_for_all_clients(bench, client):
    picture = jpeg(90, two_halves(640, 480))
    encode = unittest.mock.patch.object(
        simplejpeg, "encode_jpeg", side_effect=simplejpeg.encode_jpeg
    )
    async with bench.http.ws_connect(bench.url) as socket:
        other = Client(socket)
        await other.hear()
        for each in (client, other):
            await each.say(show=[{"camera": "front", "width": 32, "height": 32}])
            await each.nothing_comes(0.0)
        with encode as encoded:
            await bench.feed(FRONT, picture)
            for each in (client, other):
                data = (await each.picture())[3]
                assert simplejpeg.decode_jpeg_header(data)[:2] == (24, 32)
            assert encoded.call_count == 1
            # Neither has acknowledged: after a while nothing is made for them any more.
            await asyncio.sleep(0.55)
            await bench.feed(FRONT, picture)
            assert encoded.call_count == 1


def test_only_so_many_different_pictures_are_encoded(tmp_path):
    async def check(bench, client):
        async with bench.http.ws_connect(bench.url) as socket:
            other = Client(socket)
            await other.hear()
            front, rear = ({"camera": name, "width": 32} for name in ("front", "rear"))
            await client.say(show=[front, rear])
            assert "1 different pictures are made for this client" in (await client.hear())["error"]
            await other.say(show=[{"camera": "front", "width": 40}, {"camera": "rear"}])
            await other.nothing_comes()
            await bench.feed(REAR, jpeg(90, two_halves(640, 480)))
            assert (await other.picture())[0] == 1  # what needs no encoding comes all the same
            await client.say(show=[front, {"camera": "rear", "width": 40}])
            assert "2 different pictures are made already" in (await client.hear())["error"]
            await bench.feed(FRONT, jpeg(90, two_halves(640, 480)))
            assert simplejpeg.decode_jpeg_header((await client.picture())[3])[1] == 32
            assert simplejpeg.decode_jpeg_header((await other.picture())[3])[1] == 40
            await other.say(show=[front])  # what is made for another client, too
            assert simplejpeg.decode_jpeg_header((await other.picture())[3])[1] == 32
            await client.say(show=[{"camera": "rear", "width": 40}])
            await client.nothing_comes()  # it is heard before the picture is
            await bench.feed(REAR, jpeg(90, two_halves(640, 480)))
            assert simplejpeg.decode_jpeg_header((await client.picture())[3])[1] == 40
            page = bench.url.replace("/video", "/snapshot?type=png&topic=") + FRONT
            async with bench.http.get(page) as reply:
                assert reply.status == 503
                assert "the parameter ~max_encoded" in await reply.text()

    on_bench(check, max_encoded=2)(tmp_path)


def test_previews_that_pass_unchanged_take_no_place_at_the_encoder(tmp_path):
    async def check(bench, client):
        bench.pictures.published[PREVIEW] = COMPRESSED_TYPE
        async with bench.http.ws_connect(bench.url) as first, bench.http.ws_connect(
            bench.url
        ) as second:
            crowd, console = Client(first), Client(second)
            await crowd.hear()
            await console.hear()
            for who, width in ((client, 32), (crowd, 40)):
                await who.say(show=[{"camera": "rear", "width": width}])
                await who.nothing_comes()
            small = [{"camera": "front", "rate": 10, "width": 320}]
            await console.say(show=small)
            await console.nothing_comes()
            await bench.feed(PREVIEW, jpeg(90, two_halves(320, 240)))
            assert (await console.picture())[0] == 0
            # What turns out to need the encoder gets it when there is room.
            await console.say(show=[{"camera": "front", "rate": 10, "width": 64}])
            assert "2 different pictures are made already" in (await console.hear())["error"]

    on_bench(check, max_encoded=2)(tmp_path)


@on_bench
async def test_acknowledgements_of_several_cameras_in_one_message(bench, client):
    await client.say(show=[{"camera": "front"}, {"camera": "rear"}])
    for _ in range(2):
        for topic in (FRONT, REAR):
            await bench.feed(topic, jpeg())
        used = [(await client.picture())[:2] for _ in range(2)]
        assert {camera for camera, _ in used} == {0, 1}
        await client.say(ack=used)
    await client.say(ack=[[0, 1], [9, 1]])
    assert (await client.hear())["error"] == "ack is for camera 9; there are 2"


@on_bench
async def test_a_client_whose_connection_is_full_gets_the_newest_pictures_when_it_reads_on(
    bench, client
):
    connection = client.socket._response.connection.transport
    connection.pause_reading()
    names = ("front", "rear")
    await client.say(show=[{"camera": name, "credits": 8} for name in names])
    large = jpeg()[:-2] + bytes(3_000_000) + b"\xff\xd9"  # more than the system takes at once
    for count in range(20):
        for topic in (FRONT, REAR):
            await bench.feed(topic, large, captured=count)
    connection.resume_reading()
    captured = {0: [], 1: []}
    while not all(times and times[-1] == 19 for times in captured.values()):
        camera, number, when, data = await client.picture()
        assert data == large
        captured[camera].append(when)
        await client.ack(camera, number)
    for times in captured.values():
        assert times == sorted(set(times))
        assert len(times) < 12


def with_preview(check):
    """Make a test on a bench whose front camera has a preview."""

    @on_bench
    async def test(bench, client):
        bench.pictures.published[PREVIEW] = COMPRESSED_TYPE
        async with bench.http.ws_connect(bench.url) as socket:
            other = Client(socket)
            assert len((await other.hear())["cameras"]) == 2
            await check(bench, other)

    test.__doc__ = check.__doc__
    return test


SMALL = jpeg(80, two_halves(320, 240))


@pytest.mark.parametrize(
    ("wish", "topic"),
    [
        ({"width": 320, "rate": 10}, PREVIEW),
        ({"width": 320, "height": 240, "rate": 10}, PREVIEW),
        ({"height": 100, "rate": 1}, PREVIEW),
        ({}, FRONT),
        ({"rate": 10}, FRONT),
        ({"width": 320}, FRONT),
        ({"width": 320, "rate": 10.5}, FRONT),
        ({"width": 320, "rate": 10, "quality": 90}, FRONT),
    ],
)
def test_the_preview_serves_those_for_whom_it_is_enough(tmp_path, wish, topic):
    @with_preview
    async def check(bench, client):
        await client.say(show=[{"camera": "front", **wish}])
        await bench.feed(topic, SMALL)
        camera, number, _, data = await client.picture()
        assert bench.pictures.events == [("subscribe", topic)]
        if wish.get("width") and "quality" not in wish:
            assert data == SMALL
        if "height" in wish:
            assert simplejpeg.decode_jpeg_header(data)[0] == wish["height"]
        await client.ack(camera, number)

    check(tmp_path)


@with_preview
async def test_a_preview_that_is_too_small_gives_way_to_the_full_picture(bench, client):
    await client.say(show=[{"camera": "front", "width": 400, "rate": 10}])
    await bench.feed(PREVIEW, SMALL)
    await client.nothing_comes(0.0)
    await bench.feed(FRONT, jpeg(80, two_halves(800, 600)))
    assert simplejpeg.decode_jpeg_header((await client.picture())[3])[:2] == (300, 400)
    await wait_until_async(lambda: len(bench.pictures.events) == 3)
    assert ("unsubscribe", PREVIEW) in bench.pictures.events


@with_preview
async def test_a_preview_that_shrinks_while_it_is_watched_gives_way_too(bench, client):
    await client.say(show=[{"camera": "front", "width": 320, "rate": 10}])
    await bench.feed(PREVIEW, SMALL)
    camera, number, _, _ = await client.picture()
    await client.ack(camera, number)
    await bench.feed(PREVIEW, jpeg(80, two_halves(160, 120)))
    await bench.feed(FRONT, SMALL)
    assert (await client.picture())[3] == SMALL


@with_preview
async def test_a_swap_changes_between_preview_and_full_picture(bench, client):
    small, large = {"camera": "front", "width": 320, "rate": 10}, {"camera": "front", "rate": 30}
    for wish, topic in ((small, PREVIEW), (large, FRONT), (small, PREVIEW)):
        await client.say(show=[wish])
        await wait_until_async(lambda topic=topic: list(bench.pictures.receivers) == [topic])
        await bench.feed(topic, SMALL)
        await client.picture()


@on_bench
async def test_hidden_cameras_are_for_instructors(bench, client):
    bench.pictures.published = {OVERVIEW: COMPRESSED_TYPE, **bench.pictures.published}
    for role, names in (
        ("instructor", {"overview", "front", "rear"}),
        ("operator", {"front", "rear"}),
    ):
        async with bench.http.ws_connect(f"{bench.url}?role={role}") as socket:
            watcher = Client(socket)
            cameras = [each["name"] for each in (await watcher.hear())["cameras"]]
            assert set(cameras) == names
            await watcher.say(show=[{"camera": "overview"}])
            if "overview" in names:
                await bench.feed(OVERVIEW, jpeg())
                assert cameras[(await watcher.picture())[0]] == "overview"
            else:
                said = (await watcher.hear())["error"]
                assert said == 'there is no camera "overview"; known are front, rear'


@on_bench
async def test_the_rate_is_what_was_asked_for(bench, client):
    await client.say(show=[{"camera": "front", "rate": 5}])
    came = []

    async def take():
        while True:
            camera, number, _, _ = await client.picture()
            came.append(number)
            await client.ack(camera, number)

    taking = asyncio.ensure_future(take())
    begun = time.monotonic()
    for _ in range(25):
        await bench.feed(FRONT, jpeg())
        await asyncio.sleep(0.01)
    took = time.monotonic() - begun
    taking.cancel()
    assert 3 <= len(came) <= 5 * took + 3


@on_bench
async def test_views_change_and_subscriptions_follow(bench, client):
    def events():
        return bench.pictures.events

    await client.say(show=[{"camera": "front"}])
    await wait_until_async(lambda: events() == [("subscribe", FRONT)])
    await bench.feed(FRONT, jpeg())
    _, number, _, _ = await client.picture()
    await client.say(show=[{"camera": "front", "rate": 10}, {"camera": "rear"}])
    await wait_until_async(lambda: events() == [("subscribe", FRONT), ("subscribe", REAR)])
    # The view is new: it begins with the last picture, and does not wait for the old one's ack.
    _, newer, _, _ = await client.picture()
    assert newer > number
    await client.say(show=[])
    await wait_until_async(
        lambda: sorted(events()[2:]) == [("unsubscribe", FRONT), ("unsubscribe", REAR)]
    )
    await client.ack(0, newer)  # comes late, and is no mistake
    await client.nothing_comes()
    assert len(bench.server.hubs) == 0


@on_bench
async def test_a_client_that_goes_leaves_nothing(bench, client):
    await client.say(show=[{"camera": "front"}, {"camera": "rear"}])
    await wait_until_async(lambda: len(bench.server.hubs) == 2)
    client.socket._response.connection.transport.abort()
    await wait_until_async(lambda: len(bench.server.hubs) == 0)
    await wait_until_async(lambda: len(bench.pictures.events) == 4)


@on_bench
async def test_a_ping_tells_the_time_and_what_was_measured(bench, client):
    await client.say(ping=17.5)
    pong = await client.hear()
    assert pong["pong"] == 17.5
    assert abs(pong["time"] - time.time()) < 5.0
    assert pong["views"] == {}
    await client.say(show=[{"camera": "rear"}])
    for _ in range(4):
        await bench.feed(REAR, jpeg(), captured=time.time() - 0.5)
        camera, number, _, _ = await client.picture()
        await client.ack(camera, number)
    await client.say(ping=18)
    figures = (await client.hear())["views"]["rear"]
    assert 0.5 <= figures["age"] < 2.0
    assert 0.0 <= figures["round_trip"] < 1.0
    assert 0.5 <= figures["made"] <= figures["age"]
    assert figures["rate"] > 1.0


@on_bench
async def test_bad_messages_are_answered_and_change_nothing(bench, client):
    await client.say(show=[{"camera": "front"}])
    for message, said in (
        (
            {"show": [{"camera": "rear"}, {"camera": "roof"}]},
            'there is no camera "roof"; known are',
        ),
        ({"ack": [7, 1]}, "ack is for camera 7; there are 2"),
        ({"fly": 1}, "there is no message"),
    ):
        await client.say(**message)
        assert (await client.hear())["error"].startswith(said)
    await client.socket.send_bytes(b"\x00\x01")
    assert "messages must be text" in (await client.hear())["error"]
    await bench.feed(FRONT, jpeg())
    assert (await client.picture())[0] == 0
    assert bench.pictures.events == [("subscribe", FRONT)]


@on_bench
async def test_huge_texts_and_floods_end_the_connection_but_nobody_elses(bench, client):
    floods = {
        1009: ["x" * 20000],
        1008: ['{"nonsense": 1}'] * 100,
        -1008: ['{"ping": 1}'] * 3000,
    }
    for code, texts in floods.items():
        async with bench.http.ws_connect(bench.url) as socket:
            await socket.receive(timeout=HUNG)
            for text in texts:
                with contextlib.suppress(ConnectionError):
                    await socket.send_str(text)
            while (await socket.receive(timeout=HUNG)).type == aiohttp.WSMsgType.TEXT:
                pass
            assert socket.close_code == abs(code)
    await client.say(ping=2)
    assert (await client.hear())["pong"] == 2


@on_bench
async def test_a_flooding_client_that_never_reads_is_cut_off(bench, client):
    flood = await bench.http.ws_connect(bench.url, max_msg_size=0)
    flood._response.connection.transport.pause_reading()
    with contextlib.suppress(ConnectionError):
        for _ in range(3000):
            await flood.send_str('{"ping": 1}')
            await asyncio.sleep(0)
    await wait_until_async(lambda: len(bench.server.sockets._clients) == 1)
    await client.say(ping=2)
    assert (await client.hear())["pong"] == 2


def test_new_cameras_are_announced(monkeypatch, tmp_path):
    monkeypatch.setattr(video_sockets, "CAMERAS_PERIOD", 0.02)

    @on_bench
    async def check(bench, client):
        bench.pictures.down = True
        await asyncio.sleep(0.1)
        bench.pictures.down = False
        mast = "/telex/cameras/mast/image_raw"
        bench.pictures.published[mast] = "sensor_msgs/Image"
        described = await client.hear()
        assert described["cameras"][2] == {"name": "mast", "topic": mast}
        await client.say(show=[{"camera": "mast"}])
        await wait_until_async(lambda: bench.pictures.events == [("subscribe", mast)])
        # Its compressed topic comes a moment later: that is the one to watch.
        bench.pictures.published[f"{mast}/compressed"] = COMPRESSED_TYPE
        await wait_until_async(lambda: ("subscribe", f"{mast}/compressed") in bench.pictures.events)
        await wait_until_async(lambda: bench.pictures.events[-1] == ("unsubscribe", mast))

    check(tmp_path)


def test_a_camera_that_cannot_be_subscribed_to_is_tried_again(monkeypatch, tmp_path):
    monkeypatch.setattr(video_sockets, "CAMERAS_PERIOD", 0.02)

    @on_bench
    async def check(bench, client):
        subscribe, tries = bench.pictures.subscribe, []

        def fail_first(topic, receive):
            tries.append(topic.name)
            if len(tries) == 1:
                raise OSError("no connection")
            return subscribe(topic, receive)

        bench.pictures.subscribe = fail_first
        await client.say(show=[{"camera": "front"}])
        await bench.feed(FRONT, jpeg())
        assert (await client.picture())[3] == jpeg()
        assert bench.warnings == [f"cannot subscribe to {FRONT}: no connection"]

    check(tmp_path)


def test_the_servers_end_says_goodbye(tmp_path):
    async def run():
        bench = Bench(tmp_path)
        async with contextlib.AsyncExitStack() as stack:
            await stack.enter_async_context(bench.connected())
            socket = await bench.http.ws_connect(bench.url)
            await socket.receive(timeout=HUNG)
            closing = asyncio.ensure_future(socket.receive(timeout=HUNG))
            # aiohttp by itself would wait longer for the answer of the other client
            await asyncio.wait_for(bench.server.sockets.dismiss(), 5.0)
            assert (await closing).data == 1001

    asyncio.run(asyncio.wait_for(run(), HUNG_TEST))
