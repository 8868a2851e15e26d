"""The pages: their links lead somewhere, and their lines can be read beside code."""

from __future__ import annotations

import re
from functools import lru_cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGES = ("*.md", "docs/**/*.md", "src/*/*.md", "benchmarks/*.md")
WIDTH = 100
FENCED = re.compile(r"^```.*?^```", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"\]\(([^)\s#]*)(?:#([^)\s]*))?\)")
NOT_WRAPPED = ("|", "![")
"""Beginnings of lines that Markdown does not let wrap: tables and pictures."""


def pages():
    return [page for pattern in PAGES for page in sorted(ROOT.glob(pattern))]


@lru_cache(maxsize=None)
def prose(page):
    return FENCED.sub("", page.read_text(encoding="utf-8"))


def anchors(page):
    """What headings are called in links."""
    plain = (re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", line) for line in headings(page))
    return {re.sub(r"[^\w\- ]", "", line.strip().lower()).replace(" ", "-") for line in plain}


def headings(page):
    return re.findall(r"^#+ (.*)$", prose(page), re.MULTILINE)


def test_the_pages_are_found():
    assert ROOT / "README.md" in pages()


@pytest.mark.parametrize("page", pages(), ids=lambda page: str(page.relative_to(ROOT)))
class TestEachPage:
    def test_its_links_lead_somewhere(self, page):
        for path, anchor in LINK.findall(prose(page)):
            if "://" in path:
                continue
            target = (page.parent / path).resolve() if path else page
            assert target.exists(), path
            if anchor and target.suffix == ".md":
                assert anchor in anchors(target), f"{path}#{anchor}"

    def test_its_lines_are_wrapped(self, page):
        for line in prose(page).splitlines():
            wrapped = len(line) <= WIDTH or line.lstrip().startswith(NOT_WRAPPED)
            # A long word, or a link, stands alone.
            assert wrapped or " " not in line.strip(), line


def test_the_readme_is_read_in_five_minutes():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 150
