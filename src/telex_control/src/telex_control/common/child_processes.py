"""Child processes that do not outlive their starter.

The starter is a thread, as prctl(2) has it: what is to last as long as the process is started by a
thread that does.
"""

from __future__ import annotations

DIES_WITH_US = ("setpriv", "--pdeathsig", "TERM")
"""Put before a command: it is asked to end, too, when its starter is killed."""

KILLED_WITH_US = ("setpriv", "--pdeathsig", "KILL")
"""The same for one that may be stopped (SIGSTOP) then: it would keep any other signal for later."""
