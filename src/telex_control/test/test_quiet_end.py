"""Command lines whose reader goes before they have said all."""

from __future__ import annotations

import subprocess
import sys
from typing import Tuple

import pytest

from telex_control.common.quiet_end import SIGPIPE_STATUS

HEAD = """
import argparse, os, sys
from telex_control.common.quiet_end import ending_quietly
"""


def ended(body: str, reads: bool) -> Tuple[int, str, str]:
    """Status, output and errors of a command line, whose output is read or else closed."""
    command = [sys.executable, "-c", HEAD + body]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.PIPE, text=True
    )
    assert process.stdin
    assert process.stdout
    assert process.stderr
    if not reads:
        process.stdout.close()
    # It waits for this, so that its reader has gone for certain.
    process.stdin.close()
    said = process.stdout.read() if reads else ""
    errors = process.stderr.read()
    process.stderr.close()
    process.stdout.close()
    return process.wait(timeout=60.0), said, errors


MANY = """
def main():
    sys.stdin.read()
    for number in range(100_000):
        print(number)
    return 3
sys.exit(ending_quietly(main))
"""
FEW = MANY.replace("100_000", "3")
HELP = """
def main():
    sys.stdin.read()
    argparse.ArgumentParser(description="Does it.").parse_args(["--help"])
sys.exit(ending_quietly(main))
"""


@pytest.mark.parametrize("body", [MANY, FEW, HELP], ids=["many", "few", "help"])
def test_it_ends_without_a_word_when_its_reader_has_gone(body: str) -> None:
    assert ended(body, reads=False) == (SIGPIPE_STATUS, "", "")


@pytest.mark.parametrize(("body", "status"), [(MANY, 3), (FEW, 3), (HELP, 0)])
def test_what_is_read_ends_as_ever(body: str, status: int) -> None:
    found, said, errors = ended(body, reads=True)
    assert (found, errors) == (status, "")
    assert "2\n" in said or "Does it." in said


def test_another_pipe_that_breaks_is_an_error() -> None:
    body = """
def main():
    reading, writing = os.pipe()
    os.close(reading)
    os.write(writing, b"x")
sys.exit(ending_quietly(main))
"""
    status, _, errors = ended(body, reads=True)
    assert status == 1
    assert "BrokenPipeError" in errors
