"""Each setup.py names every Python package of its folder: what it leaves out is not installed."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

SOURCES = Path(__file__).resolve().parents[1] / "src"
FILES = sorted(SOURCES.glob("*/setup.py"))


def named(path):
    """Value of the keyword `packages` in a setup.py."""
    keywords = [
        node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.keyword)
    ]
    (packages,) = [ast.literal_eval(each.value) for each in keywords if each.arg == "packages"]
    return packages


def there(folder):
    """Names of all packages below a folder."""
    return sorted(
        ".".join(file.parent.relative_to(folder).parts) for file in folder.rglob("__init__.py")
    )


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.parent.name)
def test_every_package_is_named(path):
    assert sorted(named(path)) == there(path.parent / "src")


def test_every_folder_of_packages_has_a_setup_file():
    assert {path.parents[2] for path in SOURCES.glob("*/src/*/__init__.py")} == {
        path.parent for path in FILES
    }
