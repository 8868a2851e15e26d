"""What the tests of the web nodes share: a ROS master, node processes, a probe on the ROS side."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import signal
import subprocess
import sys
import threading
from pathlib import Path

import rosgraph
from waiting import wait_until

from telex_control.common.child_processes import DIES_WITH_US
from telex_experiments.rigs.private_master import PrivateMaster

PACKAGE = Path(__file__).resolve().parents[1]
SOURCE = PACKAGE / "src"
START = 60.0
"""Time (s) within which a node has to come up."""


def stop_process(process, number=signal.SIGINT, timeout=30.0):
    """Stop a process and all of its group; return its exit status, None where it hung."""
    with contextlib.suppress(ProcessLookupError):
        process.send_signal(number)
    try:
        return process.wait(timeout)
    except subprocess.TimeoutExpired:
        return None
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait(timeout)
        for stream in (process.stdin, process.stdout, process.stderr):
            if stream is not None:
                stream.close()


class Ros:
    """A ROS master on a free port, and the processes that use it; all end with it."""

    def __init__(self):
        self._master = PrivateMaster()
        self.environment = self._master.environment(
            PYTHONUNBUFFERED="1",
            PYTHONPATH=os.pathsep.join(
                [str(SOURCE), *filter(None, [os.environ.get("PYTHONPATH")])]
            ),
        )
        self.logs = Path(self.environment["ROS_LOG_DIR"])
        self.master = rosgraph.Master("/test", self._master.uri)
        self.processes = []

    def __enter__(self):
        self._master.__enter__()
        return self

    def __exit__(self, *_):
        # An end in order takes seconds, and nobody asserts anything of it here.
        while self.processes:
            stop_process(self.processes.pop(), signal.SIGKILL)
        self._master.__exit__()

    def start(self, command, **options):
        process = subprocess.Popen(
            [*DIES_WITH_US, *command], env=self.environment, start_new_session=True, **options
        )
        self.processes.append(process)
        return process

    def start_node(self, name, *arguments, **options):
        """Start a node of this package in the namespace /telex."""
        return self.start(
            [sys.executable, str(PACKAGE / "nodes" / name), "__ns:=/telex", *arguments], **options
        )

    def stop(self, process, number=signal.SIGINT):
        self.processes.remove(process)
        return stop_process(process, number)

    def serve(self, name, node_name=None, *arguments):
        """Start a server node on a free port; return its process and its address."""
        node_name = node_name or name
        process = self.start_node(name, "_port:=0", f"__name:={node_name}", *arguments)
        return process, wait_until(lambda: self.param(f"/telex/{node_name}/url"), timeout=START)

    def param(self, name):
        try:
            return self.master.getParam(name)
        except rosgraph.MasterError:
            return None

    def subscribers(self, topic):
        return dict(self.master.getSystemState()[1]).get(topic, [])

    def publishers(self, topic):
        return dict(self.master.getSystemState()[0]).get(topic, [])

    def probe(self):
        return Probe(self)


class Probe:
    """Speaks with the process of web_probe.py."""

    def __init__(self, ros):
        self._ros = ros
        self._process = ros.start(
            [sys.executable, str(Path(__file__).with_name("web_probe.py"))],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self._answers = queue.Queue()
        self.heard = {}
        self.requests = []
        self._requests_of = {}
        threading.Thread(target=self._read, args=(self._process.stdout,), daemon=True).start()
        assert self._answer(START) == "ready"

    def _read(self, lines):
        with contextlib.suppress(ValueError):  # the pipe is closed when the test ends
            for line in lines:
                news = json.loads(line)
                if "topic" in news:
                    self.heard[news["topic"]].append((news["time"], news["message"]))
                elif "service" in news:
                    self.requests.append(news["request"])
                    self._requests_of.setdefault(news["service"], []).append(news["request"])
                else:
                    self._answers.put(news)

    def _answer(self, timeout=10.0):
        news = self._answers.get(timeout=timeout)
        assert "error" not in news, news
        return news["answer"]

    def do(self, what, **order):
        self._process.stdin.write(json.dumps({"do": what, **order}) + "\n")
        self._process.stdin.flush()
        return self._answer()

    def subscribe(self, topic, type_name):
        """Hear a topic from now on: all that is published, if it has publishers already."""
        self.heard[topic] = []
        self.do("subscribe", topic=topic, type=type_name)
        wait_until(
            lambda: not self._ros.publishers(topic) or self.do("connected", topic=topic),
            f"the publisher of {topic} to have answered",
        )

    def publish(self, topic, type_name, message=None, **options):
        self.do("publish", topic=topic, type=type_name, message=message, **options)

    def requests_of(self, service):
        """Return what was asked of a service so far, None for an empty request."""
        # What the probe has said is read by a thread, which may be behind the page.
        self.do("wait")
        return list(self._requests_of.get(service, []))

    def forget_requests(self):
        self.requests.clear()
        self._requests_of.clear()

    def messages(self, topic):
        return [message for _, message in tuple(self.heard[topic])]
