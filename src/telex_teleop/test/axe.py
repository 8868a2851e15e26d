"""Findings of axe-core about a page: what people cannot read, reach or have read to them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Callable, List

from waiting import wait_until

SOURCE = Path(__file__).resolve().parent / "javascript/node_modules/axe-core/axe.min.js"

RUN = """
window.axeFound = null;
axe.run({resultTypes: ["violations"]}).then(
  ({violations}) => {
    window.axeFound = violations.flatMap(({id, nodes}) => nodes.map(
      ({html, any}) => `${id}: ${html.slice(0, 160)} ${any[0]?.message ?? ""}`));
  },
  (error) => { window.axeFound = [String(error)]; },
);
"""


def lacking() -> str:
    """Return what to do to have axe-core; empty where it is."""
    return "" if SOURCE.exists() else "axe-core is not installed (launch_scripts/setup.sh --test)"


def findings(run: Callable[[str], Any]) -> List[str]:
    """Let axe-core look at a page as it is now.

    Parameters
    ----------
    run
        Runs statements in the page, and returns what they return.
    """
    # A page as it comes into being is not looked at in the middle of a transition.
    run("if (typeof axe === 'undefined') {" + SOURCE.read_text() + "\n}" + RUN)
    found: List[str] = wait_until(
        lambda: run("return window.axeFound && {found: window.axeFound}"), timeout=60.0
    )["found"]
    return found
