"""A headless Chromium that is told what to do by its DevTools protocol, over a pipe.

The pipe needs no port, so the browser may stand in a network namespace of its own; and it goes on
where a WebDriver would not, when processes of the browser are stopped or killed.
"""

from __future__ import annotations

import base64
import contextlib
import json
import os
import shutil
import signal
import subprocess
import tempfile
import threading
import time
from pathlib import Path
from string import ascii_lowercase, digits
from typing import Any, Dict, List, Optional, Sequence, Tuple

from telex_control.common.child_processes import DIES_WITH_US
from telex_experiments.rigs.private_master import descendants
from telex_experiments.rigs.private_simulator import cpu_seconds

ANSWER_WITHIN = 60.0
"""Longest wait (s) for an answer of the browser, on a machine that is busy with something else."""

CLOCK_SAMPLES = 50
"""Questions for the page's clock, of which the quickest counts."""

FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)
"""Without a window; it asks no other host for anything, and nobody for a choice."""

_KEYS: Dict[str, Tuple[str, int]] = {
    **{f"Key{sign.upper()}": (sign, ord(sign.upper())) for sign in ascii_lowercase},
    **{f"Digit{sign}": (sign, ord(sign)) for sign in digits},
    **{f"Numpad{sign}": (sign, 0x60 + int(sign)) for sign in digits},
    **{f"F{number}": (f"F{number}", 0x6F + number) for number in range(1, 13)},
    **{
        f"Arrow{way}": (f"Arrow{way}", 0x25 + n)
        for n, way in enumerate("Left Up Right Down".split())
    },
    "Backspace": ("Backspace", 0x08),
    "Tab": ("Tab", 0x09),
    "Enter": ("Enter", 0x0D),
    "Escape": ("Escape", 0x1B),
    "PageUp": ("PageUp", 0x21),
    "PageDown": ("PageDown", 0x22),
    "End": ("End", 0x23),
    "Home": ("Home", 0x24),
    "Insert": ("Insert", 0x2D),
    "Delete": ("Delete", 0x2E),
    "Space": (" ", 0x20),
    "Semicolon": (";", 0xBA),
    "Equal": ("=", 0xBB),
    "Comma": (",", 0xBC),
    "Minus": ("-", 0xBD),
    "Period": (".", 0xBE),
    "Slash": ("/", 0xBF),
    "Backquote": ("`", 0xC0),
    "BracketLeft": ("[", 0xDB),
    "BracketRight": ("]", 0xDD),
    "Quote": ("'", 0xDE),
}
"""Keys by their position: their sign on a US keyboard, or their name; and their virtual code."""


def code_of(key: str) -> str:
    """Return the position of a key, which its sign on a US keyboard may name as well."""
    return next((code for code, (sign, _) in _KEYS.items() if sign == key), key)


class BrowserError(RuntimeError):
    """The browser did not do what it was told; the message says what."""


class PageLeftError(BrowserError, LookupError):
    """The page that was asked has been left for another one; it may be asked again."""


def program() -> Optional[str]:
    """Return the path of Chromium; None where there is none."""
    return shutil.which("chromium") or shutil.which("chromium-browser")


def lacking() -> str:
    """Return what to do to have a browser; empty where there is one."""
    return "" if program() else "chromium is not installed (apt-get install chromium)"


class Chromium:
    """A browser with one page.

    Parameters
    ----------
    url
        What the page shows.
    before
        Words before the command, such as ``("nsenter", "--net=/run/netns/NAME")``.
    size
        Width and height of the window (pixels).
    script
        Runs in every document before the page's own; what the page allows itself to load is not
        looked at then.
    exact
        Whether `size` is that of the page, which shows no scroll bars.
    listens
        Whether `complaints` are noted.

    Use it as a context manager.

    Attributes
    ----------
    complaints : list of str
        Errors that the page has logged, or has not caught, and what it could not load.
    addresses : list of str
        What the page has asked for while the protocol's domain ``Network`` was enabled.

    Raises
    ------
    BrowserError
        There is no Chromium, or it does not start.
    """

    def __init__(
        self,
        url: str,
        before: Sequence[str] = (),
        size: Tuple[int, int] = (1280, 720),
        script: str = "",
        exact: bool = False,
        listens: bool = False,
    ) -> None:
        path = program()
        if path is None:
            raise BrowserError(lacking())
        self._profile = tempfile.mkdtemp(prefix="telex-chromium-")
        order_read, order_write = os.pipe()
        news_read, news_write = os.pipe()
        # The browser listens to descriptor 3 and answers on 4.
        redirect = f'exec "$@" 3<&{order_read} 4>&{news_write}'
        self._process = subprocess.Popen(
            [
                *("bash", "-c", redirect, "bash"),
                *before,
                *DIES_WITH_US,
                path,
                *FLAGS,
                "--remote-debugging-pipe",
                *(("--hide-scrollbars",) if exact else ()),
                "--window-size={},{}".format(*size),
                f"--user-data-dir={self._profile}",
                "about:blank",
            ],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            pass_fds=(order_read, news_write),
            start_new_session=True,
        )
        os.close(order_read)
        os.close(news_write)
        self._orders = os.fdopen(order_write, "wb", buffering=0)
        self._news = os.fdopen(news_read, "rb")
        self._number = 0
        self._answers: Dict[int, Dict[str, Any]] = {}
        self._workers: List[str] = []
        self.complaints: List[str] = []
        self.addresses: List[str] = []
        self._arrived = threading.Condition()
        self._ended = False
        threading.Thread(target=self._read, daemon=True).start()
        try:
            self._target, self.session = self._attach()
            self._prepare(size if exact else None, script, listens)
            self.call("Page.navigate", url=url)
            self.call("Page.bringToFront")
        except BaseException:
            self.close()
            raise

    def _prepare(self, size: Optional[Tuple[int, int]], script: str, listens: bool) -> None:
        for domain in ("Log", "Runtime") if listens else ():
            self.call(f"{domain}.enable")
        if size is not None:
            self.resize(size)
        if script:
            self.call("Page.enable")
            self.call("Page.setBypassCSP", enabled=True)
            self.call("Page.addScriptToEvaluateOnNewDocument", source=script)

    def __enter__(self) -> Chromium:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def close(self) -> None:
        """End the browser."""
        self.kill()
        self._process.wait()
        for pipe in (self._orders, self._news):
            with contextlib.suppress(OSError):
                pipe.close()
        shutil.rmtree(self._profile, ignore_errors=True)

    # The protocol

    def _read(self) -> None:
        text = b""
        descriptor = self._news.fileno()
        while True:
            try:
                data = os.read(descriptor, 1 << 20)
            except OSError:
                data = b""
            if not data:
                break
            *messages, text = (text + data).split(b"\0")
            for message in messages:
                news = json.loads(message)
                if "id" in news:
                    with self._arrived:
                        self._answers[news["id"]] = news
                        self._arrived.notify_all()
                elif _target(news) == "worker":
                    self._workers.append(news["params"]["sessionId"])
                elif _complaint(news):
                    self.complaints.append(_complaint(news))
                elif _address(news):
                    self.addresses.append(_address(news))
        with self._arrived:
            self._ended = True
            self._arrived.notify_all()

    def tell(self, method: str, session: Optional[str] = None, **parameters: Any) -> int:
        """Give an order without waiting for its answer; returns its number."""
        self._number += 1
        order: Dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if session is not None:
            order["sessionId"] = session
        try:
            self._orders.write(json.dumps(order).encode() + b"\0")
        except (OSError, ValueError) as error:
            raise BrowserError(f"the browser has ended: {error}") from None
        return self._number

    def call(self, method: str, **parameters: Any) -> Dict[str, Any]:
        """Give an order to the page, and return the answer."""
        return self._answer(method, self.tell(method, self.session, **parameters))

    def _call_browser(self, method: str, **parameters: Any) -> Dict[str, Any]:
        return self._answer(method, self.tell(method, **parameters))

    def _answer(self, method: str, number: int) -> Dict[str, Any]:
        with self._arrived:
            if not self._arrived.wait_for(
                lambda: number in self._answers or self._ended, ANSWER_WITHIN
            ):
                raise BrowserError(f"the browser did not answer {method} in {ANSWER_WITHIN:g} s")
            answer = self._answers.pop(number, {"error": {"message": "the browser has ended"}})
        if "error" in answer:
            kind = PageLeftError if "navigated" in answer["error"]["message"] else BrowserError
            raise kind(f"{method}: {answer['error']['message']}")
        result: Dict[str, Any] = answer["result"]
        return result

    def _attach(self) -> Tuple[str, str]:
        targets = self._call_browser("Target.getTargets")["targetInfos"]
        page = next(each["targetId"] for each in targets if each["type"] == "page")
        attached = self._call_browser("Target.attachToTarget", targetId=page, flatten=True)
        return page, attached["sessionId"]

    # The page

    def resize(self, size: Tuple[int, int]) -> None:
        """Give the page another width and height (px)."""
        width, height = size
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def go(self, url: str) -> None:
        """Show another page, or the same one anew, and wait until it is loaded.

        A page that goes elsewhere by itself meanwhile, such as one that loads itself anew, takes
        the place of what is asked for, which is asked for again.
        """
        end = time.monotonic() + ANSWER_WITHIN
        while True:
            with contextlib.suppress(PageLeftError):
                self.evaluate("void (window.telexLeft = true)")
            problem = self.call("Page.navigate", url=url).get("errorText")
            if not problem:
                break
            if problem != "net::ERR_ABORTED" or time.monotonic() > end:
                raise BrowserError(f"{url}: {problem}")
            time.sleep(0.05)
        self.wait_for(url, "window.telexLeft === undefined && document.readyState === 'complete'")

    def evaluate(self, script: str) -> Any:
        """Return the value of an expression on the page; where it is a promise, of that."""
        return self._evaluate(script, self.session)

    def evaluate_in_worker(self, script: str) -> Any:
        """Return the value of an expression in the page's only worker."""
        if not self._workers:
            self.call(
                "Target.setAutoAttach", autoAttach=True, waitForDebuggerOnStart=False, flatten=True
            )
            end = time.monotonic() + ANSWER_WITHIN
            while not self._workers:
                if time.monotonic() > end:
                    raise BrowserError("the page has no worker")
                time.sleep(0.05)
        return self._evaluate(script, self._workers[0])

    def _evaluate(self, script: str, session: str) -> Any:
        method = "Runtime.evaluate"
        number = self.tell(
            method, session, expression=script, returnByValue=True, awaitPromise=True
        )
        answer = self._answer(method, number)
        if "exceptionDetails" in answer:
            raise BrowserError(f"{script[:80]}: {_told(answer)}")
        return answer["result"].get("value")

    def wait_for(self, what: str, script: str, timeout: float = ANSWER_WITHIN) -> Any:
        """Wait until an expression on the page is true, and return its value."""
        # What the expression asks for may not be there yet.
        script = f"(() => {{ try {{ return ({script}); }} catch {{ return null; }} }})()"
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            # Nor may the page be.
            with contextlib.suppress(PageLeftError):
                value = self.evaluate(script)
                if value:
                    return value
            time.sleep(0.05)
        raise BrowserError(f"not within {timeout:g} s: {what}")

    def click(self, selector: str) -> None:
        """Click the first element of a CSS selector.

        Raises
        ------
        BrowserError
            There is none.
        """
        self.evaluate(f"document.querySelector({json.dumps(selector)}).click()")

    def screenshot(self) -> bytes:
        """Return the page as PNG, once it is loaded."""
        self.wait_for("the page to be loaded", "document.readyState === 'complete'")
        return base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])

    def clock(self) -> Tuple[float, float]:
        """Difference of this process's monotonic clock to the page's (s), and its uncertainty."""
        best, offset = float("inf"), 0.0
        for _ in range(CLOCK_SAMPLES):
            asked = time.monotonic()
            there = self.evaluate("performance.now()") / 1e3
            answered = time.monotonic()
            if answered - asked < best:
                best, offset = answered - asked, 0.5 * (asked + answered) - there
        return offset, 0.5 * best

    def key(self, kind: str, code: str, repeats: bool = False) -> int:
        """Press (``keyDown``) or let go (``keyUp``) a key; returns the number for `handled`."""
        sign, virtual = _KEYS[code]
        text = {"Enter": "\r"}.get(code, sign if len(sign) == 1 else "")
        # What has a text is a character as well; a button is pressed by that of Enter.
        typed = {"text": text} if text and kind == "keyDown" else {}
        return self.tell(
            "Input.dispatchKeyEvent",
            self.session,
            type="rawKeyDown" if kind == "keyDown" and not text else kind,
            code=code,
            key=sign,
            windowsVirtualKeyCode=virtual,
            autoRepeat=repeats,
            **typed,
        )

    def handled(self, number: int) -> None:
        """Wait until the page has handled an event: what it is asked does not queue behind them."""
        self._answer("Input.dispatchKeyEvent", number)

    def press(self, code: str) -> None:
        """Press a key, and keep it down."""
        self.key("keyDown", code)

    def repeat(self, code: str) -> None:
        """Say again that a key is down, as a keyboard does while it is held."""
        self.key("keyDown", code, repeats=True)

    def release(self, code: str) -> None:
        """Let a key go."""
        self.key("keyUp", code)

    def open_tab(self) -> str:
        """Open another tab behind the page, and return its name."""
        name: str = self._call_browser("Target.createTarget", url="about:blank", background=True)[
            "targetId"
        ]
        return name

    def close_tab(self, tab: str) -> None:
        """Close another tab."""
        self._call_browser("Target.closeTarget", targetId=tab)

    def show(self, tab: Optional[str] = None) -> None:
        """Bring a tab to the front, by default the page; does not wait."""
        self.tell("Target.activateTarget", targetId=tab or self._target)

    # Its processes

    @property
    def pid(self) -> int:
        """The browser's main process."""
        for pid, kind in self.processes().items():
            if kind == "browser":
                return pid
        raise BrowserError("the browser has ended")

    def processes(self) -> Dict[int, str]:
        """All processes with their kinds: browser, renderer, gpu-process and others."""
        found = {}
        for pid in [self._process.pid, *descendants(self._process.pid)]:
            words = _words(pid)
            if f"--user-data-dir={self._profile}" in words or "--type=" in " ".join(words):
                kinds = [word[7:] for word in words if word.startswith("--type=")]
                found[pid] = kinds[0] if kinds else "browser"
        return found

    def renderers(self) -> List[int]:
        """Processes that carry out and draw pages."""
        return [pid for pid, kind in self.processes().items() if kind == "renderer"]

    def cpu(self, *kinds: str) -> float:
        """CPU time (s) that processes of some kinds have used, of all by default."""
        total = 0.0
        for pid, kind in self.processes().items():
            if not kinds or kind in kinds:
                with contextlib.suppress(OSError):
                    total += cpu_seconds(pid)
        return total

    def signal(self, number: int, pids: Optional[List[int]] = None) -> None:
        """Send a signal to some processes, to all by default."""
        for pid in self.processes() if pids is None else pids:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, number)

    def kill(self) -> None:
        """Kill all processes at once, as a crash or a power cut does."""
        self.signal(signal.SIGKILL)


def _words(pid: int) -> List[str]:
    """Words of a command; a process of Chromium's writes spaces between them."""
    try:
        command = Path(f"/proc/{pid}/cmdline").read_bytes().decode(errors="replace")
    except OSError:
        return []
    return command.replace("\0", " ").split()


def _complaint(news: Dict[str, Any]) -> str:
    """Return the error that the browser tells of; empty where it tells of none."""
    method, params = news["method"], news["params"]
    if method == "Runtime.exceptionThrown":
        return _told(params)
    if method == "Runtime.consoleAPICalled" and params["type"] in ("error", "assert"):
        parts = (each.get("value", each.get("description", "")) for each in params["args"])
        return " ".join(str(part) for part in parts)
    if method == "Log.entryAdded" and params["entry"]["level"] == "error":
        return f"{params['entry']['text']} {params['entry'].get('url', '')}".strip()
    return ""


def _address(news: Dict[str, Any]) -> str:
    """Return what the page asks for, if that is what the browser tells."""
    method, params = news["method"], news["params"]
    if method == "Network.requestWillBeSent":
        return str(params["request"]["url"])
    return str(params["url"]) if method == "Network.webSocketCreated" else ""


def _target(news: Dict[str, Any]) -> str:
    """Return what the browser has attached us to, if that is what it tells."""
    if news["method"] != "Target.attachedToTarget":
        return ""
    return str(news["params"]["targetInfo"]["type"])


def _told(answer: Dict[str, Any]) -> str:
    """Return what an expression has thrown."""
    details = answer["exceptionDetails"]
    return str(details.get("exception", {}).get("description", details["text"]))
