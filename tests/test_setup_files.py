"""Each setup.py names every Python package of its folder: what it leaves out is not installed."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

SOURCES = Path(__file__).resolve().parents[1] / "src"
FILES = sorted(SOURCES.glob("*/setup.py"))


def named(path):
    """Folder and names of the packages of a setup.py."""
    values = {
        node.arg: ast.literal_eval(node.value)
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.keyword) and node.arg
    }
    return path.parent / values["package_dir"][""], values["packages"]


def there(folder):
    """Names of all packages below a folder."""
    return sorted(
        ".".join(file.parent.relative_to(folder).parts) for file in folder.rglob("__init__.py")
    )


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.parent.name)
def test_every_package_is_named(path):
    folder, packages = named(path)
    assert sorted(packages) == there(folder)


def test_every_folder_of_packages_has_a_setup_file():
    found = {
        path.parents[2]
        for folder in ("src", "cad")
        for path in SOURCES.glob(f"*/{folder}/*/__init__.py")
    }
    assert found == {path.parent for path in FILES}
