"""Reading YAML files that users write."""

from __future__ import annotations

import io

import pytest
import yaml

from telex_control.common import yaml_files
from telex_control.common.yaml_files import load_yaml


def read(text):
    return load_yaml(io.StringIO(text))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{day: 2001-99-99}", "month must be in"),
        ("0b_", "invalid literal"),
        ("!!int ''", "index out of range"),
        ("!!bool maybe", "maybe"),
        ("!!timestamp today", "cannot be"),
    ],
)
def test_a_value_that_cannot_be_is_an_error_of_the_file(text, said):
    with pytest.raises(yaml.YAMLError, match=said):
        read(text)


def test_a_file_in_another_encoding_is_an_error_of_the_file(tmp_path):
    (tmp_path / "file.yaml").write_bytes("name: Köln".encode("latin-1"))
    with pytest.raises(yaml.YAMLError, match="utf-8"), open(
        tmp_path / "file.yaml", encoding="utf-8"
    ) as file:
        load_yaml(file)


def test_of_merged_structs_the_first_named_counts_as_yaml_has_it():
    text = "[&a {x: 1, y: 1}, &b {x: 2, z: 2}, {<<: [*a, *b, *a], z: 3}, {<<: [*b, *a, *b, *b]}]"
    assert read(text) == yaml.safe_load(text)
    assert read(text)[2:] == [{"x": 1, "y": 1, "z": 3}, {"x": 2, "y": 1, "z": 2}]


def test_merges_of_merges_do_not_multiply(monkeypatch):
    sizes = []
    flatten = yaml_files._Loader.flatten_mapping

    def measured(loader, node):
        flatten(loader, node)
        sizes.append(len(node.value))

    monkeypatch.setattr(yaml_files._Loader, "flatten_mapping", measured)
    names = [f"a{number}" for number in range(6)]
    lines = [f"{names[0]}: &{names[0]} {{x: 1, y: 2}}"]
    for before, name in zip(names, names[1:]):
        lines.append(f"{name}: &{name} {{<<: [{', '.join([f'*{before}'] * 5)}]}}")
    assert read("\n".join(lines)) == {name: {"x": 1, "y": 2} for name in names}
    assert max(sizes) == len(names)
