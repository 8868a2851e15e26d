"""Folders and handlers of other processes, mounted on the video server."""

from __future__ import annotations

import asyncio
import contextlib
import gzip
import socket

import aiohttp
import pytest
from aiohttp import web
from waiting import wait_until_async
from web_fakes import HUNG_TEST, FakePictures, FakeRos, served
from yarl import URL

from telex_teleop.web.bridge.clients.access import Access
from telex_teleop.web.rights import Rights
from telex_teleop.web.server_config import VideoServerConfig, read_server_config
from telex_teleop.web.video import handlers
from telex_teleop.web.video.mounts import Mount
from telex_teleop.web.video.video_server_app import VideoServer

pytestmark = pytest.mark.slow

CLIENT, INSTRUCTOR = "token=sesame", "token=teacher&role=instructor"


class Bench:
    """A video server, what is mounted on it, and a handler that tells what it was asked."""

    def __init__(self, tmp_path):
        self.console, self.folder = tmp_path / "console", tmp_path / "pages"
        for folder in (self.console / "js", self.folder / "inner"):
            folder.mkdir(parents=True)
        (self.console / "index.html").write_text("console")
        (self.console / "js" / "main.js").write_text("start();")
        (self.folder / "index.html").write_text("exercises")
        (self.folder / "inner" / "index.html").write_text("inner")
        (self.folder / "data.json").write_text("{}")
        (tmp_path / "secret").write_text("secret")
        (self.folder / "link").symlink_to(tmp_path / "secret")
        self.files = {}
        for name, token in (("token", "sesame"), ("instructor_token", "teacher")):
            (tmp_path / name).write_text(token)
            (tmp_path / name).chmod(0o600)
            self.files[f"{name}_file"] = str(tmp_path / name)
        self.pictures = FakePictures({})
        self.warnings = []
        self.asked = []
        self.app = web.Application()
        self.app.router.add_route("*", "/training/told{rest:.*}", self._tell)

    def mount(self, name="training", **mount):
        self.pictures.params[f"~mounts/{name}"] = mount

    async def _tell(self, request):
        self.asked.append(request)
        headers = {key.lower(): value for key, value in request.headers.items()}
        return web.json_response(
            {
                "method": request.method,
                "path": request.raw_path,
                "headers": headers,
                "body": (await request.read()).decode(),
            },
            headers={"X-Answer": "yes", "Connection": "close, X-Between", "X-Between": "1"},
        )

    @contextlib.asynccontextmanager
    async def served(self, *, tokens=True, **config):
        """Serve handler and video server; gives a session whose addresses begin at the latter."""
        config = VideoServerConfig(**(self.files if tokens else {}), **config)
        server = VideoServer(config, self.pictures, "/telex/", self.console, self.warnings.append)
        async with served(self.app) as self.handler, served(
            server.make_app()
        ) as self.url, aiohttp.ClientSession(self.url) as http:
            yield http


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)


def run(coroutine):
    asyncio.run(asyncio.wait_for(coroutine, HUNG_TEST))


async def status_of(http, path, method="GET", **options):
    async with http.request(method, path, allow_redirects=False, **options) as reply:
        return reply.status


def test_the_files_of_a_folder_are_served_while_it_is_mounted(bench):
    async def check():
        async with bench.served() as http:
            assert await status_of(http, f"/training/?{CLIENT}") == 404
            bench.mount(folder=str(bench.folder))
            for path, text in (("", "exercises"), ("inner/", "inner"), ("data.json", "{}")):
                async with http.get(f"/training/{path}?{CLIENT}") as reply:
                    assert (reply.status, await reply.text()) == (200, text)
                    assert reply.headers["Cache-Control"] == "no-cache"
            part = {"Range": "bytes=1-"}
            async with http.get(f"/training/data.json?{CLIENT}", headers=part) as reply:
                assert (reply.status, await reply.text()) == (206, "}")
            assert await status_of(http, f"/training/?{CLIENT}", "HEAD") == 200
            for method in ("POST", "PUT", "DELETE"):
                assert await status_of(http, f"/training/?{CLIENT}", method) == 405
            async with http.get(f"/training?{CLIENT}") as reply:
                assert str(reply.url) == f"{bench.url}/training/?{CLIENT}"
            bench.pictures.params.clear()
            assert await status_of(http, f"/training/?{CLIENT}") == 404

    run(check())


@pytest.mark.parametrize("path", ["../secret", "%2e%2e/secret", "..%2fsecret", "link", "%00"])
def test_nothing_outside_the_folder_is_served(bench, path):
    async def check():
        bench.mount(folder=str(bench.folder), access="all")
        async with bench.served() as http:
            address = URL(f"{bench.url}/training/{path}", encoded=True)
            assert await status_of(http, address) == 404
            address = URL(f"{bench.url}/training/{bench.folder.parent}/secret", encoded=True)
            assert await status_of(http, address) == 404

    run(check())


def test_a_mount_hides_no_page_of_the_console(bench):
    async def check():
        (bench.folder / "main.js").write_text("other();")
        bench.mount("js", folder=str(bench.folder), access="all")
        bench.mount("stream", folder=str(bench.folder), access="all")
        async with bench.served() as http:
            async with http.get("/js/main.js") as reply:
                assert await reply.text() == "start();"
            assert await status_of(http, f"/stream?{CLIENT}") == 400  # of the stream, without topic

    run(check())


NOBODY = ""


@pytest.mark.parametrize(
    ("access", "statuses"),
    [
        ("all", {NOBODY: (200, 401), CLIENT: (200, 200), INSTRUCTOR: (200, 200)}),
        ("client", {NOBODY: (401, 401), CLIENT: (200, 200), INSTRUCTOR: (200, 200)}),
        ("instructor", {NOBODY: (401, 401), CLIENT: (403, 403), INSTRUCTOR: (200, 200)}),
    ],
)
def test_who_gets_the_files_and_who_reaches_the_handler(bench, access, statuses):
    async def check():
        async with bench.served() as http:
            bench.mount(folder=str(bench.folder), handler=bench.handler, access=access)
            for who, (of_file, of_handler) in statuses.items():
                assert await status_of(http, f"/training/data.json?{who}") == of_file
                assert await status_of(http, f"/training/told?{who}") == of_handler
                assert await status_of(http, f"/training/told?{who}", "POST") == of_handler
            wrong = {"Authorization": "Bearer wrong"}
            assert await status_of(http, "/training/told", headers=wrong) == 401
        reached = sum(status == 200 for _, status in statuses.values())
        assert len(bench.asked) == 2 * reached

    run(check())


def test_a_handler_gets_the_request_and_is_told_who_asks(bench):
    async def check():
        async with bench.served() as http:
            bench.mount(handler=bench.handler)
            query = "a=1%2B2&token=teacher&role=instructor&b&name=Ann+%C3%84"
            async with http.post(
                URL(f"{bench.url}/training/told%20you?{query}", encoded=True),
                data="hello",
                headers={"Authorization": "Bearer teacher", "X-Mine": "1", "Referer": "http://x/"},
            ) as reply:
                told = await reply.json()
                assert (reply.status, reply.headers["X-Answer"]) == (200, "yes")
                assert "X-Between" not in reply.headers
            assert told["method"] == "POST"
            path = "/training/told%20you?a=1%2B2&role=instructor&b&name=Ann+%C3%84"
            assert told["path"] == path
            assert told["body"] == "hello"
            headers = told["headers"]
            assert headers["x-telex-role"] == "instructor"
            assert headers["x-telex-name"] == "Ann%20%C3%84"
            assert headers["x-mine"] == "1"
            assert headers["content-length"] == "5"
            assert f"http://{headers['host']}" == bench.handler
            assert not {"authorization", "referer"} & set(headers)
            async with http.get(f"/training/told?{CLIENT}&name=%0Aworse") as reply:
                headers = (await reply.json())["headers"]
            assert (headers["x-telex-role"], headers["x-telex-name"]) == ("operator", "")

    run(check())


def test_nobody_can_say_himself_who_he_is(bench):
    async def check():
        async with bench.served() as http:
            bench.mount(handler=bench.handler)
            for name in ("X-Telex-Role", "x-telex-name", "X-TELEX-OTHER"):
                said = {name: "instructor"}
                assert await status_of(http, f"/training/told?{CLIENT}", headers=said) == 400
            # One that is its own handler by mistake does not ask itself for ever.
            bench.mount(handler=bench.url)
            assert await status_of(http, f"/training/told?{CLIENT}") == 401
            assert bench.asked == []

    run(check())


@pytest.mark.parametrize("path", ["../told", "%2e%2e/told", "..%2ftold", "a/./told", "..%5ctold"])
def test_no_path_leads_out_of_a_handlers_mount(bench, path):
    async def check():
        async with bench.served() as http:
            bench.mount(handler=bench.handler)
            address = URL(f"{bench.url}/training/{path}?{CLIENT}", encoded=True)
            assert await status_of(http, address) == 404
            assert bench.asked == []

    run(check())


@pytest.mark.parametrize(
    ("head", "status"),
    [
        (b"GET http://example.com/training/told?token=sesame HTTP/1.1", 200),  # not from there
        (b"GET //example.com/training/told?token=sesame HTTP/1.1", 404),
        (b"CONNECT 127.0.0.1:1 HTTP/1.1", 404),
        (b"GET /training/told?token=sesame HTTP/1.1\r\nX-Mine: \xff", 200),
        (b"GET /training/\xff\xfe?token=sesame HTTP/1.1", 400),
        (b"GET /training/told?token=sesame HTTP/1.1\r\nTransfer-Encoding: nonsense", 400),
        (
            b"POST /training/told?token=sesame HTTP/1.1\r\n"
            b"Content-Length: 2\r\nTransfer-Encoding: chunked",
            400,
        ),
    ],
)
def test_heads_that_mean_it_ill(bench, head, status):
    async def check():
        async with bench.served():
            bench.mount(handler=bench.handler)
            reader, writer = await asyncio.open_connection("127.0.0.1", URL(bench.url).port)
            writer.write(head + b"\r\nHost: localhost\r\n\r\n")
            answer = (await reader.readline()).split()
            assert answer[1:2] == [str(status).encode()]
            writer.close()

    run(check())


def test_where_no_token_is_asked_for_a_foreign_page_cannot_post(bench):
    async def check():
        async with bench.served(tokens=False) as http:
            bench.mount(handler=bench.handler)
            foreign = {"Origin": "http://evil.example"}
            assert await status_of(http, "/training/told", "POST", headers=foreign) == 403
            assert await status_of(http, "/training/told", "POST") == 200
            own = {"Origin": bench.url}
            assert await status_of(http, "/training/told", "POST", headers=own) == 200
        async with bench.served() as http:  # who knows the token is no foreign page
            bench.mount(handler=bench.handler)
            path = f"/training/told?{CLIENT}"
            assert await status_of(http, path, "POST", headers=foreign) == 200

    run(check())


def test_cookies_of_one_client_do_not_go_to_another(bench):
    async def set_cookie(request):
        reply = web.Response(text=request.headers.get("Cookie", "none"))
        reply.set_cookie("who", "ann")
        reply.set_cookie("what", "exam")
        return reply

    bench.app.router.add_get("/training/cookie", set_cookie)

    async def check():
        async with bench.served() as http, aiohttp.ClientSession(
            bench.url, cookie_jar=aiohttp.CookieJar(unsafe=True)
        ) as ann:
            bench.mount(handler=bench.handler)
            async with ann.get(f"/training/cookie?{CLIENT}") as reply:
                assert set(reply.cookies) == {"who", "what"}
            async with ann.get(f"/training/cookie?{CLIENT}") as reply:
                assert "who=ann" in await reply.text()
            async with http.get(f"/training/cookie?{CLIENT}") as reply:
                assert await reply.text() == "none"

    run(check())


def test_answers_pass_as_they_are(bench):
    async def redirect(_request):
        raise web.HTTPSeeOther("/training/told")

    async def packed(request):
        assert request.headers["Accept-Encoding"] == "identity"
        headers = {"Content-Encoding": "gzip", "Content-Security-Policy": "default-src 'none'"}
        return web.Response(body=gzip.compress(b"packed"), headers=headers, status=418)

    bench.app.router.add_get("/training/redirect", redirect)
    bench.app.router.add_get("/training/packed", packed)

    async def check():
        async with bench.served() as http:
            bench.mount(handler=bench.handler)
            async with http.get(f"/training/redirect?{CLIENT}", allow_redirects=False) as reply:
                assert (reply.status, reply.headers["Location"]) == (303, "/training/told")
            asked = {"Accept-Encoding": "identity"}
            async with http.get(f"/training/packed?{CLIENT}", headers=asked) as reply:
                assert (reply.status, await reply.read()) == (418, b"packed")
                assert reply.headers["Content-Security-Policy"] == "default-src 'none'"
                assert reply.headers["X-Content-Type-Options"] == "nosniff"
            async with http.head(f"/training/packed?{CLIENT}", headers=asked) as reply:
                assert (reply.status, await reply.read()) == (418, b"")
                assert int(reply.headers["Content-Length"]) == len(gzip.compress(b"packed"))
            assert await status_of(http, f"/training/nowhere?{CLIENT}") == 404
            # What a client packs comes unpacked.
            packing = {"Content-Encoding": "gzip"}
            async with http.post(
                f"/training/told?{CLIENT}", data=gzip.compress(b"x" * 1000), headers=packing
            ) as reply:
                assert (await reply.json())["body"] == "x" * 1000

    run(check())


def test_bodies_pass_as_streams(bench):
    async def echo(request):
        reply = web.StreamResponse()
        await reply.prepare(request)
        async for chunk in request.content.iter_any():
            await reply.write(chunk.upper())
        return reply

    bench.app.router.add_post("/training/echo", echo)

    async def check():
        async with bench.served() as http:
            bench.mount(handler=bench.handler)
            words = asyncio.Queue()

            async def speak():
                while True:
                    word = await words.get()
                    if not word:
                        return
                    yield word

            words.put_nowait(b"one")
            async with http.post(f"/training/echo?{CLIENT}", data=speak()) as reply:
                assert await reply.content.readany() == b"ONE"  # before the end of the question
                words.put_nowait(b"two")
                assert await reply.content.readany() == b"TWO"
                words.put_nowait(b"")
                assert await reply.content.readany() == b""

    run(check())


def test_a_request_that_is_too_large_is_refused(bench):
    async def pieces(count):
        for _ in range(count):
            yield b"x" * 400

    async def check():
        async with bench.served(max_upload=1000) as http:
            bench.mount(handler=bench.handler)
            path = f"/training/told?{CLIENT}"
            assert await status_of(http, path, "POST", data=b"x" * 1000) == 200
            assert await status_of(http, path, "POST", data=pieces(2)) == 200
            assert await status_of(http, path, "POST", data=b"x" * 1001) == 413
            assert await status_of(http, path, "POST", data=pieces(3)) == 413
            # Small on the way, large when it is unpacked.
            bomb = {"data": gzip.compress(b"x" * 9999), "headers": {"Content-Encoding": "gzip"}}
            assert await status_of(http, path, "POST", **bomb) == 413
        assert len(bench.asked) <= 4

    run(check())


def test_a_handler_that_is_gone_is_502_and_one_that_comes_back_is_found(bench):
    async def check():
        async with bench.served() as http:
            with socket.socket() as closed:
                closed.bind(("127.0.0.1", 0))
                gone = f"http://127.0.0.1:{closed.getsockname()[1]}"
                bench.mount(handler=gone)
                for method in ("GET", "POST"):
                    async with http.request(method, f"/training/told?{CLIENT}") as reply:
                        assert reply.status == 502
                        page = await reply.text()
                        assert "502 Bad Gateway" in page
                        assert f"at {gone}, cannot be reached" in page
            assert len(bench.warnings) == 2
            bench.mount(handler=bench.handler)
            assert await status_of(http, f"/training/told?{CLIENT}") == 200

    run(check())


@contextlib.asynccontextmanager
async def raw_handler(serve):
    """Serve connections by hand; gives the address."""
    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    async with server:
        yield "http://{}:{}".format(*server.sockets[0].getsockname())


@pytest.mark.parametrize("said", [b"", b"nonsense\r\n\r\n", b"HTTP/1.1 200 OK\r\nContent-"])
def test_a_handler_that_breaks_off_before_its_answer_is_502(bench, said):
    async def serve(reader, writer):
        await reader.readuntil(b"\r\n\r\n")
        writer.write(said)
        writer.close()

    async def check():
        async with bench.served() as http, raw_handler(serve) as bench.handler:
            bench.mount(handler=bench.handler)
            assert await status_of(http, f"/training/x?{CLIENT}") == 502

    run(check())


def test_a_handler_that_is_silent_is_504_and_its_connection_ends(bench):
    ended = []

    async def serve(reader, writer):
        while await reader.read(100):
            pass
        ended.append(True)
        writer.close()

    async def check():
        async with bench.served(handler_timeout=0.2) as http, raw_handler(serve) as handler:
            bench.mount(handler=handler)
            async with http.get(f"/training/x?{CLIENT}") as reply:
                assert reply.status == 504
                assert "Nothing has moved for 0.2 s" in await reply.text()
            await wait_until_async(lambda: ended)

    run(check())


def test_a_handler_that_takes_no_more_of_an_upload_is_given_up(bench):
    async def serve(reader, writer):
        writer.transport.pause_reading()
        await asyncio.sleep(5.0)
        writer.close()

    async def check():
        async with bench.served(handler_timeout=0.3) as http, raw_handler(serve) as handler:
            bench.mount(handler=handler)
            data = b"x" * 16000000
            assert await status_of(http, f"/training/x?{CLIENT}", "POST", data=data) == 504

    run(check())


@pytest.mark.parametrize("end", ["closes", "is silent"])
def test_an_answer_that_breaks_off_does_not_pass_for_a_whole_one(bench, monkeypatch, end):
    ask = handlers.Handlers._ask

    async def ask_with_patience(self, *request):
        """The head has all the time it needs; what then never comes is soon given up."""
        reply = await ask(self, *request)
        self._timeout = 0.2
        return reply

    monkeypatch.setattr(handlers.Handlers, "_ask", ask_with_patience)

    async def serve(reader, writer):
        await reader.readuntil(b"\r\n\r\n")
        writer.write(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n4\r\nhalf\r\n")
        if end == "closes":
            writer.close()
        else:
            await reader.read(1)

    async def check():
        async with bench.served() as http, raw_handler(serve) as handler:
            bench.mount(handler=handler)
            async with http.get(f"/training/x?{CLIENT}") as reply:
                assert reply.status == 200
                with pytest.raises(aiohttp.ClientError):
                    await reply.read()
            assert "has broken off" in bench.warnings[-1]

    run(check())


def test_a_handler_hears_when_its_client_has_gone(bench):
    begun, ended = [], []

    async def serve(reader, writer):
        await reader.readuntil(b"\r\n\r\n")
        writer.write(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n4\r\nhalf\r\n")
        begun.append(True)
        await reader.read()
        ended.append(True)
        writer.close()

    async def check():
        async with bench.served() as http, raw_handler(serve) as handler:
            bench.mount(handler=handler)
            async with http.get(f"/training/x?{CLIENT}") as reply:
                assert await reply.content.readany() == b"half"
                reply.close()
            await wait_until_async(lambda: ended)

    run(check())


def test_requests_that_are_too_many_are_refused_and_not_kept_waiting(bench, monkeypatch):
    monkeypatch.setattr(handlers, "MAX_REQUESTS", 1)

    async def endless(request):
        reply = web.StreamResponse()
        await reply.prepare(request)
        while True:
            await reply.write(b"more")
            await asyncio.sleep(0.01)

    bench.app.router.add_get("/training/endless", endless)

    async def check():
        async with bench.served() as http:
            bench.mount(handler=bench.handler)
            async with http.get(f"/training/endless?{CLIENT}") as reply:
                assert reply.status == 200
                assert await status_of(http, f"/training/told?{CLIENT}") == 503
                reply.close()
            while await status_of(http, f"/training/told?{CLIENT}") != 200:
                await asyncio.sleep(0.01)  # run() ends it if it never is

    run(check())


def test_a_handler_cannot_take_a_connection_over(bench):
    async def serve(reader, writer):
        head = await reader.readuntil(b"\r\n\r\n")
        assert b"upgrade" not in head.lower()
        writer.write(b"HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n")
        writer.close()

    async def check():
        async with bench.served() as http, raw_handler(serve) as handler:
            bench.mount(handler=handler)
            asked = {"Connection": "Upgrade", "Upgrade": "websocket"}
            assert await status_of(http, f"/training/x?{CLIENT}", headers=asked) == 200

    run(check())


@pytest.mark.parametrize(
    ("mount", "said"),
    [
        ({}, "folder and handler are both empty"),
        ("http://127.0.0.1:1", "a struct is needed"),
        ({"folder": "pages"}, "folder is 'pages'; it must be an absolute path"),
        ({"folder": "/x", "acess": "all"}, "acess is unknown; known are access, folder, handler"),
        ({"folder": "/x", "access": "nobody"}, "all, client, instructor are possible"),
        ({"handler": "http://10.0.0.1:80"}, "it must be http://127.0.0.1:PORT"),
        ({"handler": "http://localhost:80"}, "it must be http://127.0.0.1:PORT"),
        ({"handler": "https://127.0.0.1:80"}, "it must be http://127.0.0.1:PORT"),
        ({"handler": "http://127.0.0.1:80@evil.example"}, "it must be http://127.0.0.1:PORT"),
        ({"handler": "http://127.0.0.1:80/path"}, "it must be http://127.0.0.1:PORT"),
        ({"handler": "http://127.0.0.1:99999"}, "it must be http://127.0.0.1:PORT"),
        ({"handler": "http://127.0.0.1:80\n"}, "it must be http://127.0.0.1:PORT"),
    ],
)
def test_a_mount_that_makes_no_sense_is_refused_by_its_name(bench, mount, said):
    async def check():
        bench.pictures.params["~mounts/training"] = mount
        async with bench.served() as http, http.get(f"/training/?{CLIENT}") as reply:
            assert reply.status == 500
            # What a parameter holds is for the log alone.
            assert "The parameter ~mounts/training cannot be used" in await reply.text()
        (warning,) = bench.warnings
        assert warning.startswith("~mounts/training")
        assert said in warning

    run(check())


def test_without_a_master_nothing_is_mounted_and_the_answer_is_503(bench):
    def no_master(_name):
        raise ConnectionRefusedError("no master")

    async def check():
        async with bench.served() as http:
            bench.pictures.parameter = no_master
            assert await status_of(http, f"/training/?{CLIENT}") == 503

    run(check())


def test_a_server_that_is_started_again_takes_no_offence_at_what_is_mounted():
    values = {"mounts": {"training": {"folder": "/x"}}}
    assert read_server_config(VideoServerConfig, values, "/v") == VideoServerConfig()
    assert Mount(handler="http://127.0.0.1:65535").access == "client"


def test_no_client_of_the_bridge_can_mount_anything():
    for plain in (False, True):
        resolve = FakeRos().resolve
        access = Access(Rights.read(), resolve, "e_stop", instructor=True, plain=plain)
        for name in ("", "/mounts", "/mounts/training", "/mounts/training/folder"):
            assert not access.allows("set", f"/telex/video_server{name}")
