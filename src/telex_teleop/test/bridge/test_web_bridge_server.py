"""The bridge as a server: connections, who may connect, and what happens when they end."""

from __future__ import annotations

import asyncio
import json
import time

import aiohttp
import pytest
from geometry_msgs.msg import Twist
from waiting import wait_until_async
from web_fakes import FakeRos, on_loop, served

from telex_teleop.web.bridge.bridge_app import Rosbridge
from telex_teleop.web.server_config import RosbridgeConfig
from telex_teleop.web.tokens import Tokens

pytestmark = [pytest.mark.real_time, pytest.mark.waiting]

DRIVE = {"op": "advertise", "topic": "/drive", "type": "geometry_msgs/Twist"}
AHEAD = {"op": "publish", "topic": "/drive", "msg": {"linear": {"x": 1.0}}}


class Bench:
    def __init__(self, tokens=Tokens(), params=None, **config):  # noqa: B008
        self.ros = FakeRos()
        self.ros.params.update(params or {})
        self.warnings = []
        self.bridge = Rosbridge(RosbridgeConfig(**config), self.ros, self.warnings.append, tokens)

    def served(self):
        return served(self.bridge.make_app(), "ws")


@on_loop
async def test_operations_travel_both_ways():
    bench = Bench()
    async with bench.served() as url, aiohttp.ClientSession() as client:
        async with client.ws_connect(url) as socket, client.ws_connect(f"{url}/any") as other:
            await socket.send_json(DRIVE)
            await socket.send_json(AHEAD)
            await socket.send_str("nonsense")
            assert (await socket.receive_json(timeout=5))["op"] == "status"
            await socket.send_bytes(b"\x00")
            assert "must be text" in (await socket.receive_json(timeout=5))["msg"]
            await other.send_json({"op": "subscribe", "topic": "/known"})
            await wait_until_async(lambda: "/known" in bench.ros.receivers and bench.ros.published)
            assert bench.ros.published[0][1].linear.x == 1.0
        await wait_until_async(lambda: ("unsubscribe", "/known") in bench.ros.events)
        assert bench.ros.published[-1] == ("/drive", Twist())


@on_loop
async def test_operators_hear_nothing_of_cameras_that_the_video_server_hides():
    hidden = "video_server/hidden_cameras"
    for said, seen in ((["mast"], False), ([], True), ("mast", True), ([5, "m*st"], True)):
        bench = Bench(params={f"/telex/{hidden}": said})
        for instructor in (False, True):
            access = bench.bridge.shared.access[instructor]
            for robot in ("/telex", "/crane"):
                camera = f"{robot}/cameras/mast"
                assert access.allows("subscribe", f"{camera}/image_raw") is (seen or instructor)
                assert access.allows("get", camera) is (seen or instructor)
                assert access.allows("subscribe", f"{robot}/cameras/master/image_raw")
            assert access.allows("publish", "/telex/cameras/mast/zoom") is (seen or instructor)


@on_loop
async def test_each_connection_has_a_name_of_its_own():
    bench = Bench()
    kind = "telex_msgs/FlipperPresetHold"
    async with bench.served() as url, aiohttp.ClientSession() as client:
        sockets = [await client.ws_connect(url) for _ in range(2)]
        for socket in sockets:
            await socket.send_json({"op": "advertise", "topic": "/presets", "type": kind})
            await socket.send_json({"op": "publish", "topic": "/presets", "msg": {}})
        await wait_until_async(lambda: len(bench.ros.published) == 2)
        for socket in sockets:
            await socket.close()
    assert sorted(message.client for _, message in bench.ros.published) == ["1", "2"]


@on_loop
async def test_a_connection_that_is_cut_stops_what_it_drove():
    bench = Bench()
    async with bench.served() as url, aiohttp.ClientSession() as client:
        socket = await client.ws_connect(url)
        await socket.send_json(DRIVE)
        await socket.send_json(AHEAD)
        await wait_until_async(lambda: bench.ros.published)
        socket._response.connection.transport.abort()
        await wait_until_async(lambda: len(bench.ros.published) == 2)
        assert bench.ros.published[-1] == ("/drive", Twist())


@on_loop
async def test_the_bridges_end_stops_what_its_clients_drove():
    bench = Bench()
    async with aiohttp.ClientSession() as client:
        async with bench.served() as url:
            socket = await client.ws_connect(url, autoclose=False)
            silent = await client.ws_connect(url, autoclose=False)
            await socket.send_json(DRIVE)
            await socket.send_json(AHEAD)
            await wait_until_async(lambda: bench.ros.published)
            ends = time.monotonic()
        # Neither of the two has answered the closing handshake, for which aiohttp by itself would
        # wait longer.
        assert time.monotonic() - ends < 5.0
        assert bench.ros.published[-1] == ("/drive", Twist())
        await socket.close()
        await silent.close()


@on_loop
async def test_huge_messages_cost_their_sender_the_connection_only():
    bench = Bench(max_message_size=2000)
    async with bench.served() as url, aiohttp.ClientSession() as client:
        other, socket = await client.ws_connect(url), await client.ws_connect(url)
        await socket.send_str(json.dumps({**AHEAD, "padding": "x" * 4000}))
        answer = await socket.receive(timeout=5)
        assert answer.type == aiohttp.WSMsgType.CLOSE
        assert answer.data == aiohttp.WSCloseCode.MESSAGE_TOO_BIG
        await other.send_json({"op": "call_service", "service": "/rosapi/nodes"})
        assert (await other.receive_json(timeout=5))["result"] is True
    assert bench.ros.published == []


@on_loop
async def test_a_client_that_stops_reading_costs_bounded_memory_and_delays_nobody():
    bench = Bench(max_queue_bytes=100000)
    async with bench.served() as url, aiohttp.ClientSession() as client:
        stalled = await client.ws_connect(url)
        await stalled.send_json({"op": "subscribe", "topic": "/known"})
        await wait_until_async(lambda: "/known" in bench.ros.receivers)
        stalled._response.connection.transport.pause_reading()
        async with client.ws_connect(url) as reader:
            await reader.send_json({"op": "subscribe", "topic": "/known", "queue_length": 1})
            await reader.send_json({"op": "call_service", "service": "/rosapi/nodes"})
            assert (await reader.receive_json(timeout=5))["op"] == "service_response"
            for number in range(200):
                text = f"{number:05d}" + "x" * 20000
                bench.ros.receivers["/known"](type("S", (), {"data": text})(), None)
                heard = json.loads((await reader.receive(timeout=5)).data)
                assert heard["msg"]["data"].startswith(f"{number:05d}")
        stalled._response.connection.transport.abort()


@on_loop
async def test_a_browser_is_let_in_from_this_machine_only():
    bench = Bench(allowed_origins=("http://gui.example:3000",))
    async with bench.served() as url, aiohttp.ClientSession() as client:
        for origin in ("http://localhost:8080", "http://127.0.0.1", "http://gui.example:3000"):
            async with client.ws_connect(url, origin=origin):
                pass
        for origin in ("http://evil.example", "null", "http://gui.example", "http://[x"):
            with pytest.raises(aiohttp.WSServerHandshakeError) as refusal:
                await client.ws_connect(url, origin=origin)
            assert refusal.value.status == 403
        # A foreign name that was made to point to this machine is no name of this machine.
        rebound = {"Host": "evil.example:9090", "Origin": "http://evil.example:9090"}
        with pytest.raises(aiohttp.WSServerHandshakeError):
            await client.ws_connect(url, headers=rebound)
        by_address = {"Host": "192.0.2.1:9090", "Origin": "http://192.0.2.1:8080"}
        async with client.ws_connect(url, headers=by_address):
            pass
    assert any("add it to the parameter allowed_origins" in warning for warning in bench.warnings)


@on_loop
async def test_what_is_no_websocket_is_told_so():
    bench = Bench()
    async with bench.served() as url, aiohttp.ClientSession() as client:
        reply = await client.get(url.replace("ws:", "http:"))
        assert reply.status == 426
        assert "WebSocket" in await reply.text()


# Who may connect


async def refusal(http, url, **options):
    with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
        await http.ws_connect(url, **options)
    reply = await http.get(url.replace("ws:", "http:"), **options)
    assert reply.status == refused.value.status
    return reply.status, await reply.text()


@on_loop
async def test_who_must_know_a_token_needs_it():
    tokens = Tokens("open-sesame", "teacher")
    bench = Bench(tokens)
    async with bench.served() as url, aiohttp.ClientSession() as http:
        for query in ("", "?token=", "?token=wrong", "?role=instructor", "?token=%FF%00"):
            status, why = await refusal(http, f"{url}/{query}")
            assert status == 401
            assert "token" in why
        wrong = {"Authorization": "Bearer wrong"}
        assert (await refusal(http, f"{url}/?token={tokens.client}", headers=wrong))[0] == 401
        as_instructor = f"{url}/?role=instructor&token={tokens.client}"
        assert "instructor's token" in (await refusal(http, as_instructor))[1]
        assert (await refusal(http, f"{url}/?role=king"))[0] == 400
        good = {"Authorization": f"Bearer {tokens.client}"}
        for query, headers in (
            ("", good),
            (f"?token={tokens.client}", {}),
            (f"?token={tokens.instructor}", {}),
            (f"?role=instructor&token={tokens.instructor}", {}),
        ):
            async with http.ws_connect(f"{url}/{query}", headers=headers):
                pass
    assert any(warning.startswith("refused 127.0.0.1: ") for warning in bench.warnings)
    assert not any(tokens.client in warning for warning in bench.warnings)


@on_loop
async def test_no_more_clients_than_allowed():
    bench = Bench(max_clients=3, reserved_clients=1)
    async with bench.served() as url, aiohttp.ClientSession() as http:
        teachers = f"{url}/?role=instructor"
        async with http.ws_connect(url), http.ws_connect(url):
            assert (await refusal(http, url))[0] == 503  # the last place is for an instructor
            async with http.ws_connect(teachers):
                assert (await refusal(http, teachers))[0] == 503
        await wait_until_async(lambda: not bench.bridge.shared.control.members)
        async with http.ws_connect(teachers), http.ws_connect(url), http.ws_connect(url):
            assert (await refusal(http, url))[0] == 503


@on_loop
async def test_a_bridge_with_few_places_keeps_one_for_operators():
    bench = Bench(max_clients=2)  # and by default more reserved than that
    async with bench.served() as url, aiohttp.ClientSession() as http, http.ws_connect(url):
        assert (await refusal(http, url))[0] == 503
        async with http.ws_connect(f"{url}/?role=instructor"):
            pass


@on_loop
async def test_who_is_still_shaking_hands_has_a_place():
    bench = Bench(max_clients=3, reserved_clients=1)
    app = bench.bridge.make_app()

    async def dawdle(_request, _response):
        await asyncio.sleep(0.1)

    app.on_response_prepare.append(dawdle)
    async with served(app, "ws") as url, aiohttp.ClientSession() as http:
        tries = [http.ws_connect(url) for _ in range(6)]
        outcomes = await asyncio.gather(*tries, return_exceptions=True)
        refused = [each.status for each in outcomes if isinstance(each, Exception)]
        assert refused == [503] * 4
    await wait_until_async(lambda: not bench.bridge.shared.control.members)


@on_loop
async def test_everybody_can_see_who_is_there():
    bench = Bench()
    async with bench.served() as url, aiohttp.ClientSession() as http:
        first = await http.ws_connect(f"{url}/?name=Ann")
        teacher = await http.ws_connect(f"{url}/?role=instructor&name=%0a")
        await first.send_json(
            {"op": "advertise", "topic": "track_teleop/cmd_vel", "type": "geometry_msgs/Twist"}
        )
        await first.send_json(
            {"op": "publish", "topic": "track_teleop/cmd_vel", "msg": AHEAD["msg"]}
        )
        await wait_until_async(lambda: bench.ros.rosters and bench.ros.rosters[-1].holder == "1")
        rows = [
            (client.id, client.name, client.role, client.address, client.in_control)
            for client in bench.ros.rosters[-1].clients
        ]
        assert rows == [
            ("1", "Ann", "operator", "127.0.0.1", True),
            ("2", "", "instructor", "127.0.0.1", False),
        ]
        await first.close()
        await wait_until_async(lambda: len(bench.ros.rosters[-1].clients) == 1)
        assert bench.ros.rosters[-1].holder == ""
        await teacher.close()


@on_loop
async def test_a_client_can_ask_for_warnings_by_its_address():
    bench = Bench()
    async with bench.served() as url, aiohttp.ClientSession() as http:
        first, second = await http.ws_connect(url), await http.ws_connect(f"{url}/?status=1")
        drive = {"op": "publish", "topic": "track_teleop/cmd_vel", "type": "geometry_msgs/Twist"}
        await first.send_json({**drive, "msg": AHEAD["msg"]})
        await wait_until_async(lambda: bench.bridge.shared.control.holder is not None)
        await second.send_json({**drive, "msg": AHEAD["msg"]})
        assert "client 1 holds control" in (await second.receive_json(timeout=5))["msg"]
        await first.close()
        await second.close()
