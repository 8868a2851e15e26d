"""The command ``class``: serves the page of a class on the instructor's machine; needs no ROS."""

from __future__ import annotations

import argparse
import asyncio
import os
import signal
import socket
import sys
from pathlib import Path
from typing import Optional, Sequence, Tuple

from telex_control.common.file_catalog import package_path
from telex_control.common.params import ConfigError
from telex_teleop.web.listening import BindError, bind, serve, url_of
from telex_teleop.web.token_files import read_or_make_token
from telex_teleop.web.tokens import is_loopback

from ..classroom.class_app import PREFIX, ClassApp
from ..classroom.stations_file import ClassStation, StationsError, load_stations

_PORT = 8070
_TOKEN_FILE = "~/.ros/telex_class_token"


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the command; returns its exit status."""
    options = _parser().parse_args(arguments)
    try:
        stations = load_stations(options.stations)
        if options.check:
            names = ", ".join(station.name for station in stations)
            print(f"{options.stations}: OK, {len(stations)} stations: {names}")
            return 0
        token = _token(options.address, options.token_file)
        listener = bind(options.address, options.port, "class")
    except (StationsError, ConfigError, BindError) as error:
        print(error, file=sys.stderr)
        return os.EX_CONFIG
    url = f"{url_of('http', listener)}{PREFIX}/{f'?token={token}' if token else ''}"
    asyncio.run(_serve(stations, token, listener, url))
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="class",
        description="Shows all stations of a class on one page; docs/instructor/class.md describes"
        " the file of stations.",
    )
    parser.add_argument("stations", type=Path, metavar="FILE", help="stations, as YAML")
    parser.add_argument(
        "--address", default="127.0.0.1", help="to listen on; 0.0.0.0: all networks (%(default)s)"
    )
    parser.add_argument(
        "--port", type=_port, default=_PORT, help="0: any free one (%(default)s)", metavar="PORT"
    )
    parser.add_argument(
        "--token-file",
        default="",
        metavar="FILE",
        help="of the token that browsers must give, mode 0600, made if absent; without it one is "
        f"asked for only on other addresses than this machine's: {_TOKEN_FILE}",
    )
    parser.add_argument("--check", action="store_true", help="only say whether FILE is right")
    return parser


def _port(text: str) -> int:
    try:
        port = int(text)
    except ValueError:
        port = -1
    if not 0 <= port <= 65535:
        raise argparse.ArgumentTypeError(f"it is {text[:20]!r}; 0 to 65535 is possible")
    return port


def _token(address: str, file: str) -> str:
    """Token that browsers must give; empty: none.

    Raises
    ------
    ConfigError
    """
    if not file and is_loopback(address):
        return ""
    path = os.path.abspath(os.path.expanduser(file or _TOKEN_FILE))
    if not file:
        os.makedirs(os.path.dirname(path), exist_ok=True)
    return read_or_make_token(path, "--token-file")


async def _serve(
    stations: Tuple[ClassStation, ...], token: str, listener: socket.socket, url: str
) -> None:
    loop, stop = asyncio.get_running_loop(), asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, stop.set)
    pages = Path(package_path("telex_training"), "pages")
    console = Path(package_path("telex_teleop"), "console", "js")
    app = ClassApp(stations, token, pages, console).make_app()
    await serve(app, listener, stop, lambda: print(f"The class is at {url}", flush=True))
