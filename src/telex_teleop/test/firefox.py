"""Headless Firefox by WebDriver BiDi, which it speaks without a driver program beside it.

The protocol: https://www.w3.org/TR/webdriver-bidi/.
"""

from __future__ import annotations

import asyncio
import json
import os
import re
import shutil
import signal
import subprocess
import threading

import aiohttp

from telex_control.common.child_processes import DIES_WITH_US

_TIMEOUT = 60.0  # s, for a machine that has other things to do
_LISTENING = re.compile(r"WebDriver BiDi listening on (ws://\S+)")
# It asks no other host for anything, and nobody for a choice; and it waits for no disk, for what it
# keeps is thrown away.
_PREFERENCES = {
    "app.update.enabled": False,
    "browser.cache.disk.enable": False,
    "browser.sessionstore.resume_from_crash": False,
    "browser.shell.checkDefaultBrowser": False,
    "browser.startup.homepage_override.mstone": "ignore",
    "datareporting.policy.dataSubmissionEnabled": False,
    "extensions.update.enabled": False,
    "network.captive-portal-service.enabled": False,
    "network.connectivity-service.enabled": False,
    "services.settings.server": "data:,",
    "toolkit.storage.synchronous": 0,
    "toolkit.telemetry.enabled": False,
}


def firefox():
    """Return the program's path; None where there is none."""
    return shutil.which("firefox-esr") or shutil.which("firefox")


class Firefox:
    """A browser with one page; `quit` ends it.

    It takes no screenshots: for each canvas that a worker draws and of which it has not presented a
    frame yet, Firefox (153) holds the page up for 10 s, whenever somebody wants its pixels.

    Parameters
    ----------
    folder : Path
        For what it keeps; its own.
    """

    def __init__(self, folder):
        lines = [
            f"user_pref({json.dumps(key)}, {json.dumps(value)});"
            for key, value in _PREFERENCES.items()
        ]
        (folder / "user.js").write_text("\n".join(lines))
        command = ["--headless", "--no-remote", "--profile", str(folder)]
        self._process = subprocess.Popen(
            [*DIES_WITH_US, firefox(), *command, "--remote-debugging-port", "0"],
            env={**os.environ, "HOME": str(folder)},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self._count = 0
        self._answers = {}
        self.complaints = []
        try:
            self._wait(self._connect(self._address()))
            self.command("session.new", capabilities={})
            self.command("session.subscribe", events=["log.entryAdded"])
            self._page = self.command("browsingContext.getTree")["contexts"][0]["context"]
        except BaseException:
            self.quit()
            raise

    def quit(self):
        if hasattr(self, "_http"):
            self._wait(self._http.close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        self._process.stderr.close()

    def _address(self):
        for line in self._process.stderr:
            found = _LISTENING.search(line)
            if found:
                # What it says from now on has to go somewhere, or it would wait for a reader.
                threading.Thread(target=self._process.stderr.read, daemon=True).start()
                return f"{found.group(1)}/session"
        raise RuntimeError(f"Firefox ended with status {self._process.wait()}")

    def _wait(self, work):
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(_TIMEOUT)

    async def _connect(self, address):
        self._http = aiohttp.ClientSession()
        self._socket = await self._http.ws_connect(address, max_msg_size=0)
        self._reader = asyncio.ensure_future(self._read())

    async def _read(self):
        async for message in self._socket:
            data = json.loads(message.data)
            if "id" in data:
                self._answers.pop(data["id"]).set_result(data)
            elif data.get("params", {}).get("level") in ("error", "warn"):
                self.complaints.append(data["params"]["text"])

    async def _ask(self, method, params):
        self._count += 1
        answer = self._answers[self._count] = self._loop.create_future()
        await self._socket.send_json({"id": self._count, "method": method, "params": params})
        return await answer

    def command(self, method, **params):
        """Give a command; returns its result."""
        answer = self._wait(self._ask(method, params))
        if answer["type"] == "error":
            raise RuntimeError(f"{method}: {answer['message']}")
        return answer["result"]

    def get(self, url):
        """Load a page."""
        self.command("browsingContext.navigate", context=self._page, url=url, wait="complete")

    def resize(self, width, height):
        viewport = {"width": width, "height": height}
        self.command("browsingContext.setViewport", context=self._page, viewport=viewport)

    def evaluate(self, expression):
        """Return the value of an expression in the page, as JSON can have it."""
        result = self.command(
            "script.evaluate",
            expression=f"JSON.stringify({expression})",
            target={"context": self._page},
            awaitPromise=True,
        )
        if result["type"] == "exception":
            raise RuntimeError(result["exceptionDetails"]["text"])
        return json.loads(result["result"].get("value", "null"))

    def keys(self, kind, *keys):
        """Press keys ("keyDown") or let them go ("keyUp")."""
        actions = [{"type": kind, "value": key} for key in keys]
        self._perform({"type": "key", "id": "keyboard", "actions": actions})

    def click(self, selector):
        """Click on an element's middle."""
        box = f"document.querySelector({json.dumps(selector)}).getBoundingClientRect()"
        place = self.evaluate(
            f"(({{x, y, width, height}}) => [x + width / 2, y + height / 2])({box})"
        )
        x, y = (round(each) for each in place)
        actions = [
            {"type": "pointerMove", "x": x, "y": y},
            {"type": "pointerDown", "button": 0},
            {"type": "pointerUp", "button": 0},
        ]
        self._perform({"type": "pointer", "id": "mouse", "actions": actions})

    def _perform(self, source):
        self.command("input.performActions", context=self._page, actions=[source])
