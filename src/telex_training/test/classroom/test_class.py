"""The class's server between stand-ins of stations and browsers, in one process."""

from __future__ import annotations

import asyncio
import contextlib
import time
from pathlib import Path
from types import SimpleNamespace
from urllib.parse import quote

import aiohttp
import pytest
from aiohttp import web
from waiting import wait_until_async
from yarl import URL

from telex_experiments.classroom.stand_in_station import StandInStation
from telex_teleop.web.listening import bind, serve, url_of
from telex_training.classroom import poller, station_client, watch
from telex_training.classroom.answers import (
    BadAnswerError,
    Course,
    courses_of,
    json_of,
    merged,
    state_of,
)
from telex_training.classroom.class_app import ClassApp
from telex_training.classroom.stations_file import ClassStation
from telex_training.classroom.watch import CONNECTING, GONE, HERE, StationWatch

PAGES = Path(__file__).parents[2] / "pages"
CONSOLE = Path(__file__).parents[3] / "telex_teleop/console/js"
RUNNING = {
    "phase": "running",
    "trial": "t1",
    "exercise": "slalom",
    "title": "Slalom",
    "setting": "day",
    "mode": "exam",
    "operator": "ann",
    "repetition": 1,
    "steps": ["out", "back"],
    "steps_done": [True, False],
    "view": "turret",
}
LEAST = """
scene: floor
steps:
  - {name: look up, until: {inside: {what: robot, zone: goal}}}
zones:
  goal: {center: [3, 0, 0], radius: 0.5}
"""
ENDED = {**RUNNING, "phase": "ended", "verdict": "passed"}


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(watch, "PERIOD", 0.05)
    monkeypatch.setattr(watch, "LONGEST_PERIOD", 0.1)
    monkeypatch.setattr(poller, "PICTURE_PERIOD", 0.05)


def run(coroutine):
    asyncio.run(asyncio.wait_for(coroutine, 30.0))


@contextlib.asynccontextmanager
async def served(stations, token=""):
    """Serve the class of some stations; gives somebody who looks at it."""
    listener = bind("127.0.0.1", 0, "test")
    stop, ready = asyncio.Event(), asyncio.Event()
    app = ClassApp(stations, token, PAGES, CONSOLE).make_app()
    serving = asyncio.ensure_future(serve(app, listener, stop, ready.set))
    await ready.wait()
    try:
        async with aiohttp.ClientSession() as http:
            yield Browser(http, url_of("http", listener))
    finally:
        stop.set()
        await serving


@contextlib.asynccontextmanager
async def classroom(*stations, token=""):
    """Serve a class of stand-ins, given with the tokens by which it asks them."""
    async with contextlib.AsyncExitStack() as stack:
        made = []
        for number, (station, own) in enumerate(stations, 1):
            await stack.enter_async_context(station.served())
            made.append(ClassStation(f"s{number}", station.address, "t" if own else "", own))
        yield await stack.enter_async_context(served(made, token))


class Browser:
    def __init__(self, http, url):
        self.http, self.url = http, url

    async def shown(self, pictures=False, **query):
        address = f"{self.url}/class/api/state{'?pictures' if pictures else ''}"
        async with self.http.get(address, params=query) as reply:
            assert reply.status == 200
            return [SimpleNamespace(**each) for each in (await reply.json())["stations"]]

    async def until(self, condition, pictures=False):
        """Wait until a condition of the stations holds, and return them."""
        end = time.monotonic() + 15.0
        while time.monotonic() < end:
            stations = await self.shown(pictures)
            if condition(*stations):
                return stations
            await asyncio.sleep(0.02)
        raise AssertionError(stations)

    async def send(self, path, content, **headers):
        address = URL(f"{self.url}/class/api/{path}", encoded=True)
        async with self.http.post(address, json=content, headers=headers) as reply:
            return reply.status, await reply.text()


def here(station):
    return station.phase == HERE


class TestStateOfAStation:
    def test_it_comes_goes_and_comes_back(self):
        seen = StationWatch(ClassStation("s", "http://127.0.0.1:1"), 100.0)
        assert (seen.phase, seen.shown(101.0)["since"]) == (CONNECTING, 1.0)
        seen.failed(102.0, "refused")
        assert (seen.phase, seen.shown(102.0)["since"]) == (GONE, 2.0)
        seen.answered(103.0, state_of(RUNNING))
        assert (seen.phase, seen.shown(110.0)["age"]) == (HERE, 7.0)
        seen.answered(111.0, state_of(RUNNING))
        seen.failed(114.0, "no answer")
        # It may have gone at any time since it was heard.
        shown = seen.shown(115.0)
        assert (shown["phase"], shown["since"], shown["reason"]) == (GONE, 4.0, "no answer")
        assert shown["state"]["operator"] == "ann"
        seen.failed(120.0, "no answer")
        assert seen.shown(121.0)["since"] == 10.0
        seen.answered(122.0, state_of(RUNNING))
        assert (seen.phase, seen.shown(122.0)["reason"]) == (HERE, "")

    def test_it_is_asked_less_often_while_it_is_gone(self, monkeypatch):
        monkeypatch.setattr(watch, "PERIOD", 1.0)
        monkeypatch.setattr(watch, "LONGEST_PERIOD", 5.0)
        seen = StationWatch(ClassStation("s", "http://127.0.0.1:1"), 0.0)
        assert seen.pause() == 1.0
        pauses = []
        for _ in range(5):
            seen.failed(1.0, "refused")
            pauses.append(seen.pause())
        assert pauses == [1.0, 2.0, 4.0, 5.0, 5.0]
        seen.answered(2.0, state_of(RUNNING))
        assert seen.pause() == 1.0

    def test_the_last_verdict_stays_when_the_next_trial_opens(self):
        seen = StationWatch(ClassStation("s", "http://127.0.0.1:1"), 0.0)
        seen.answered(1.0, state_of(ENDED))
        seen.answered(2.0, state_of({"phase": "ready", "title": "Gap"}))
        shown = seen.shown(2.0)
        assert (shown["last"]["verdict"], shown["last"]["title"]) == ("passed", "Slalom")
        assert shown["state"]["title"] == "Gap"

    def test_pictures_are_drawn_for_the_page_at_most_every_ten_seconds(self):
        seen = StationWatch(ClassStation("s", "http://127.0.0.1:1"), 0.0)
        assert [seen.may_have_drawn(now) for now in (1.0, 5.0, 10.9, 11.0, 12.0)] == [
            True,
            False,
            False,
            True,
            False,
        ]


class TestAnswers:
    def test_keys_of_another_version_are_left_out(self):
        assert state_of({**RUNNING, "mood": "good"}).operator == "ann"

    @pytest.mark.parametrize(
        ("content", "message"),
        [
            ([], "a JSON object is needed"),
            ({}, "phase is missing"),
            ({"phase": 3}, "phase is 3; a string is needed"),
            ({**RUNNING, "elapsed": float("nan")}, "elapsed is nan; it must be finite"),
            ({**RUNNING, "steps": "out"}, "steps is 'out'; a list is needed"),
            ({**RUNNING, "help": "now"}, "help is 'now'; a number is needed"),
        ],
    )
    def test_what_is_no_state_is_refused(self, content, message):
        with pytest.raises(BadAnswerError) as caught:
            state_of(content)
        assert message in str(caught.value)

    @pytest.mark.parametrize("data", [b"", b"<html>", b"\xff\xfe", b"[" * 100_000, b"9" * 5000])
    def test_what_is_no_json_is_refused(self, data):
        with pytest.raises(BadAnswerError):
            state_of(json_of(data))

    def test_what_somebody_has_reached_anywhere_counts(self):
        first = Course("c", "C", ("a", "b"), {"ann": ("proficient", "open")})
        second = Course("c", "C", ("a", "b"), {"ann": ("open", "working"), "bob": ("open", "open")})
        other = Course("c", "C", ("a",), {"ann": ("open",)})
        joined, alone = merged([[first], [second, other]])
        assert joined.people == {"ann": ("proficient", "working"), "bob": ("open", "open")}
        assert alone == other

    @pytest.mark.parametrize("states", [["open"], ["open", "great"], "open"])
    def test_standings_fit_their_modules(self, states):
        course = {"name": "c", "title": "C", "modules": ["a", "b"], "people": {"ann": states}}
        with pytest.raises(BadAnswerError):
            courses_of([course])


class TestStations:
    def test_one_that_vanishes_is_shown_as_gone_and_comes_back(self):
        first, second = StandInStation([RUNNING]), StandInStation([RUNNING])

        async def check():
            async with second.served():
                async with first.served():
                    pass  # its port is known now
                stations = [ClassStation("s1", first.address), ClassStation("s2", second.address)]
                async with served(stations) as browser:
                    await vanish_and_return(browser)

        async def vanish_and_return(browser):
            gone, _ = await browser.until(lambda a, b: a.phase == GONE and here(b))
            assert "it cannot be reached: Connection refused" in gone.reason
            for _ in range(2):
                async with first.served():
                    await browser.until(lambda a, b: here(a) and here(b))
                gone, _ = await browser.until(lambda a, b: a.phase == GONE and here(b))
                assert gone.state["operator"] == "ann"

        run(check())

    def test_a_wrong_scheme_and_a_wrong_name_are_said(self):
        plain = StandInStation([RUNNING])

        async def check():
            async with plain.served():
                stations = [
                    ClassStation("s1", plain.address.replace("http:", "https:")),
                    ClassStation("s2", "http://no_station.invalid:80"),
                ]
                async with served(stations) as browser:
                    scheme, name = await browser.until(
                        lambda a, b: a.phase == GONE and b.phase == GONE
                    )
                    assert "cannot be reached: it does not speak https" in scheme.reason
                    assert "name" in name.reason.lower().split("cannot be reached: ")[1]

        run(check())

    def test_a_slow_one_delays_no_other(self, monkeypatch):
        monkeypatch.setattr(station_client, "TIMEOUT", 2.0)
        slow, quick = StandInStation([RUNNING]), StandInStation([RUNNING])

        async def wait(_request):
            await asyncio.sleep(60.0)

        slow.answer = wait

        async def check():
            async with classroom((slow, ""), (quick, "")) as browser:
                await browser.until(lambda a, b: here(b))
                asked, of_slow = len(quick.asked), len(slow.asked)
                await wait_until_async(lambda: len(quick.asked) > asked + 5)
                assert len(slow.asked) <= of_slow + 1
                one, other = await browser.shown()
                assert one.phase in (CONNECTING, GONE)
                assert other.age < one.age
                one, _ = await browser.until(lambda a, b: a.phase == GONE)
                assert "no answer within" in one.reason

        run(check())

    @pytest.mark.parametrize(
        ("answer", "why"),
        [
            (lambda: web.Response(text="<html>"), "is no JSON"),
            (lambda: web.json_response([]), "is no state of a station: a JSON object is needed"),
            (lambda: web.json_response({"phase": 3}), "phase is 3"),
            (lambda: web.Response(body=b"[" * 70_000), "longer than 65536 bytes"),
            (lambda: web.Response(status=302, headers={"Location": "/other"}), "leads elsewhere"),
            (lambda: web.Response(status=404), "no training node"),
            (lambda: web.Response(status=502), "it says 502"),
            (lambda: web.Response(headers={"Content-Encoding": "gzip"}, body=b"x"), "is no JSON"),
        ],
    )
    def test_what_makes_no_sense_is_named_and_asked_again(self, answer, why):
        station = StandInStation([RUNNING])

        async def nonsense(request):
            return answer()

        station.answer = nonsense

        async def check():
            async with classroom((station, "")) as browser:
                (one,) = await browser.until(lambda a: a.phase == GONE)
                assert why in one.reason
                assert set(station.asked) == {"/training/api/state"}
                station.answer = None
                await browser.until(here)

        run(check())

    def test_a_wrong_token_is_said_and_never_shown(self):
        stations = [StandInStation([RUNNING], token="sesame") for _ in range(2)]

        async def check():
            async with classroom((stations[0], "open"), (stations[1], "sesame")) as browser:
                one, other = await browser.until(lambda a, b: a.phase == GONE and here(b))
                assert "takes the token in t for no instructor's (401)" in one.reason
                assert "sesame" not in str([one, other])
                async with browser.http.get(
                    f"{browser.url}/class/station/s2?name=eve", allow_redirects=False
                ) as reply:
                    assert reply.status == 302
                    wanted = "/instructor?role=instructor&name=eve&token=sesame"
                    assert reply.headers["Location"] == stations[1].address + wanted

        run(check())

    def test_a_token_that_was_renewed_is_read_from_its_file_again(self, tmp_path):
        station, file = StandInStation([RUNNING], token="open"), tmp_path / "token"

        def write(token, mode=0o600):
            file.write_text(token)
            file.chmod(mode)

        async def renew(browser):
            await browser.until(here)
            station._token = "sesame"
            (gone,) = await browser.until(lambda a: a.phase == GONE)
            assert f"takes the token in {file} for no instructor's (401)" in gone.reason
            write("sesame", 0o644)
            await browser.until(lambda a: "others may read" in a.reason)
            write("sesame")
            await browser.until(here)
            async with browser.http.get(
                f"{browser.url}/class/station/s1", allow_redirects=False
            ) as reply:
                assert reply.headers["Location"].endswith("?role=instructor&token=sesame")
            # Whatever meets the next one first, an order is carried out once.
            station._token = "abracadabra"
            write("abracadabra")
            content = {"exercise": "gap", "stations": {"s1": "ann"}}
            assert (await browser.send("open", content))[0] == 202
            (done,) = await browser.until(lambda a: a.order and a.order["done"])
            assert done.order["ok"], done.order
            assert len(station.sent) == 1

        async def check():
            write("open")
            async with station.served():
                made = ClassStation("s1", station.address, str(file), "open")
                async with served([made]) as browser:
                    await renew(browser)

        run(check())

    def test_letters_of_any_script_name_one_in_all_addresses(self):
        name = "Prüfstand 1 स्टेशन"
        station = StandInStation([{**RUNNING, "help": 3.0}], picture=b"\xff\xd8")

        async def check():
            async with station.served(), served([ClassStation(name, station.address)]) as browser:
                await ask(browser)

        async def ask(browser):
            (seen,) = await browser.until(lambda a: here(a) and a.picture, True)
            assert seen.name == name
            # As the page's encodeURIComponent has it.
            part = quote(name, safe="")
            for path, status in ((f"api/picture/{part}", 200), (f"station/{part}", 302)):
                address = URL(f"{browser.url}/class/{path}", encoded=True)
                async with browser.http.get(address, allow_redirects=False) as reply:
                    assert reply.status == status
            assert (await browser.send(f"help/{part}", {}))[0] == 202
            await browser.until(lambda a: a.order["done"])
            content = {"exercise": "gap", "stations": {name: "ann"}}
            assert (await browser.send("open", content))[0] == 202
            await wait_until_async(lambda: len(station.sent) == 2)

        run(check())

    def test_pictures_are_fetched_while_a_page_shows_them(self):
        station = StandInStation([RUNNING], picture=b"\xff\xd8picture")

        async def check():
            async with classroom((station, "")) as browser:
                await browser.until(here)
                await asyncio.sleep(0.3)
                assert "/snapshot" not in station.asked
                await browser.until(lambda a: a.picture is not None and a.picture > 1, True)
                async with browser.http.get(f"{browser.url}/class/api/picture/s1") as reply:
                    assert (await reply.read(), reply.content_type) == (
                        b"\xff\xd8picture",
                        "image/jpeg",
                    )
                assert (await browser.http.get(f"{browser.url}/class/api/picture/s2")).status == 404

        run(check())

    def test_where_nobody_watches_a_small_picture_is_drawn_rarely(self):
        station, topics = StandInStation([RUNNING], picture=b"\xff\xd8"), []

        async def unwatched(request):
            if request.path != "/snapshot":
                return None
            topics.append((request.query["topic"], "watched" in request.query))
            return web.Response(status=404) if "watched" in request.query else None

        station.answer = unwatched

        async def check():
            async with classroom((station, "")) as browser:
                await browser.until(lambda _: len(topics) >= 6, True)
            watched = ("cameras/turret/image_raw", True)
            assert topics[:2] == [watched, ("cameras/turret/preview", False)]
            assert set(topics[2:]) == {watched}

        run(check())


class TestOrders:
    def test_an_exercise_is_opened_on_several_stations_and_each_says_what_came_of_it(self):
        stations = [StandInStation([RUNNING]) for _ in range(3)]

        async def refuse(request):
            if request.path.endswith("/open"):
                return web.Response(status=409, text="a trial of Slalom is running (bob)\n")
            return None

        stations[1].answer = refuse
        people = {"s1": "ann", "s2": " bob "}
        given = {"exercise": "gap", "setting": "gap_20", "mode": "exam", "start": True}

        async def check():
            async with classroom(*((each, "") for each in stations)) as browser:
                assert (await browser.send("open", {**given, "stations": people}))[0] == 202
                one, two, three = await browser.until(
                    lambda a, b, _: all(x.order and x.order["done"] for x in (a, b))
                )
                assert (one.order["ok"], one.order["what"]) == (True, "gap, gap_20, exam")
                assert two.order["text"] == "a trial of Slalom is running (bob)"
                assert three.order is None
                assert stations[0].sent == [{**given, "operator": "ann"}]

        run(check())

    @pytest.mark.parametrize(
        ("content", "message"),
        [
            ([], "a JSON object is needed"),
            ({"exercise": "gap"}, "stations is missing"),
            ({"exercise": "gap", "stations": {}}, "one station at least"),
            ({"exercise": "gap", "stations": {"s9": "ann"}}, "stations/s9 is unknown; known: s1"),
            ({"exercise": "gap", "stations": {"s1": " "}}, "the trainee's name is needed"),
            ({"exercise": "", "stations": {"s1": "ann"}}, "exercise is ''"),
            ({"exercise": "gap", "mode": "test", "stations": {"s1": "ann"}}, "mode is 'test'"),
        ],
    )
    def test_what_cannot_be_ordered_is_said(self, content, message):
        station = StandInStation([RUNNING])

        async def check():
            async with classroom((station, "")) as browser:
                status, text = await browser.send("open", content)
                assert (status, message in text) == (400, True), text
                assert station.sent == []

        run(check())

    def test_help_is_taken_back_at_the_station(self):
        station = StandInStation([{**RUNNING, "help": 3.0}])

        async def check():
            async with classroom((station, "")) as browser:
                await browser.until(lambda a: a.state is not None and a.state["help"] == 3.0)
                assert (await browser.send("help/s1", {}))[0] == 202
                await browser.until(lambda a: a.state["help"] is None)
                assert station.sent == [{"help": False}]
                assert (await browser.send("help/s2", {}))[0] == 404

        run(check())

    def test_where_people_stand_is_asked_of_all_and_who_does_not_say_is_named(self):
        course = {"name": "c", "title": "C", "modules": ["a"], "people": {"ann": ["open"]}}
        stations = [StandInStation([RUNNING], courses=[course]), StandInStation([RUNNING])]

        async def refuse(request):
            return web.json_response(3) if request.path.startswith("/progress") else None

        stations[1].answer = refuse

        async def check():
            async with classroom(*((each, "") for each in stations)) as browser:
                async with browser.http.get(f"{browser.url}/class/api/progress") as reply:
                    told = await reply.json()
                assert told["courses"] == [
                    {"title": "C", "modules": ["a"], "people": {"ann": ["open"]}}
                ]
                assert "no standings" in told["missing"]["s2"]

        run(check())


class TestWhoMayLook:
    def test_with_a_token_all_but_files_asks_for_it(self):
        station = StandInStation([RUNNING])

        async def check():
            async with classroom((station, ""), token="sesame") as browser:
                for path in (
                    "api/state",
                    "api/exercises",
                    "api/texts",
                    "api/picture/s1",
                    "station/s1",
                ):
                    for query in ("", "?role=instructor", "?token=wrong"):
                        address = f"{browser.url}/class/{path}{query}"
                        async with browser.http.get(address, allow_redirects=False) as reply:
                            assert reply.status == 401, address
                assert (await browser.send("open", {}))[0] == 401
                await browser.shown(token="sesame")
                async with browser.http.get(f"{browser.url}/class?token=sesame") as reply:
                    assert str(reply.url) == f"{browser.url}/class/?token=sesame"
                    assert "class.js" in await reply.text()
                for name in ("replay/language.js", "js/language.js", "js/language/de.js"):
                    async with browser.http.get(f"{browser.url}/{name}") as reply:
                        assert reply.status == 200
                        assert "javascript" in reply.headers["Content-Type"]
                    assert "default-src 'self'" in reply.headers["Content-Security-Policy"]

        run(check())

    def test_without_a_token_foreign_pages_change_nothing(self):
        station = StandInStation([RUNNING])

        async def check():
            async with classroom((station, "")) as browser:
                content = {"exercise": "gap", "stations": {"s1": "ann"}}
                foreign = {"Origin": "http://example.org"}
                assert (await browser.send("open", content, **foreign))[0] == 403
                kind = {"Content-Type": "text/plain"}
                async with browser.http.post(
                    f"{browser.url}/class/api/open", data=b"{}", headers=kind
                ) as reply:
                    assert reply.status == 415
                assert station.sent == []

        run(check())

    def test_exercises_of_this_machine_are_offered(self):
        station = StandInStation([RUNNING])

        async def check():
            async with classroom((station, "")) as browser:
                async with browser.http.get(f"{browser.url}/class/api/exercises") as reply:
                    offered = {each["name"]: each for each in await reply.json()}
                assert offered["slalom"]["settings"][0] == "day"
                assert offered["slalom"]["modes"] == ["practice", "exam"]

        run(check())

    def test_texts_of_own_exercises_of_this_machine_are_told(self, tmp_path, monkeypatch):
        own = {
            "cellar": "title: Mop the cellar\ntexts: {de: {Mop the cellar: Den Keller wischen}}",
            "attic": "texts: {de: {look up: hochsehen}, fr: {look up: regarder}}",
            "broken": "texts: {de: {go: los}, steps: 3}",
        }
        for name, more in own.items():
            (tmp_path / f"{name}.yaml").write_text(LEAST + more, encoding="utf-8")
        monkeypatch.setenv("TELEX_EXERCISE_PATH", str(tmp_path))
        station = StandInStation([RUNNING])

        async def check():
            async with classroom((station, "")) as browser:
                async with browser.http.get(f"{browser.url}/class/api/texts") as reply:
                    told = await reply.json()
                assert told == {
                    "de": {"Mop the cellar": "Den Keller wischen", "look up": "hochsehen"},
                    "fr": {"look up": "regarder"},
                }

        run(check())
