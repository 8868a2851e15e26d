"""Files by name."""

import pytest

from telex_control.common.file_catalog import FileCatalog


class NotFoundError(Exception):
    pass


@pytest.fixture
def catalog(tmp_path, monkeypatch):
    (tmp_path / "yard.yaml").write_text("")
    monkeypatch.setenv("TELEX_TEST_PATH", str(tmp_path))
    return FileCatalog("yard", "TELEX_TEST_PATH", "telex_control", "none", ".yaml", NotFoundError)


def test_by_name_and_by_path(catalog, tmp_path):
    assert catalog.find("yard") == catalog.find(f"{tmp_path}/yard.yaml") == tmp_path / "yard.yaml"


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("garden", "there is no yard 'garden'; there are: yard; or give a file's path"),
        ("/nowhere/x.yaml", "/nowhere/x.yaml: there is no such file$"),
        ("nowhere/x.yaml", "a relative path starts from /"),
        ("~nobody_at_all/x.yaml", "~nobody_at_all/x.yaml: there is no such home directory"),
        # As for a folder that may not be searched, but for root as well.
        (f"/{'a' * 300}.yaml", "a.yaml: the file cannot be read: File name too long"),
    ],
)
def test_what_is_not_there_or_may_not_be_read_is_named(catalog, name, complaint):
    with pytest.raises(NotFoundError, match=complaint):
        catalog.find(name)
