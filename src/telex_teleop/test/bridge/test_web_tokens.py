"""Tokens in files: which ones a server asks for, and which files it takes."""

from __future__ import annotations

import os
import stat

import pytest

from telex_control.common.params import ConfigError
from telex_teleop.web.server_config import RosbridgeConfig, VideoServerConfig, read_server_config
from telex_teleop.web.token_files import read_or_make_token, read_token
from telex_teleop.web.tokens import Tokens, files_of, read_tokens

MAKESHIFT = {"token_file": "/run/a", "instructor_token_file": "/run/b"}


def write(path, text="sesame", mode=0o600):
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    path.chmod(mode)
    return str(path)


@pytest.mark.parametrize(
    ("config", "files"),
    [
        ({}, {}),
        ({"address": "127.0.0.2"}, {}),
        ({"address": "0.0.0.0"}, MAKESHIFT),
        ({"address": "0.0.0.0", "token_file": "/t"}, {**MAKESHIFT, "token_file": "/t"}),
        ({"token_file": "/t"}, {**MAKESHIFT, "token_file": "/t"}),
        ({"instructor_token_file": "/i"}, {"instructor_token_file": "/i"}),
        # A server that crashed has left them; its successor listens to this machine only.
        (MAKESHIFT, {}),
    ],
)
def test_tokens_are_asked_for_where_given_and_where_others_can_come(config, files):
    assert files_of(RosbridgeConfig(**config), MAKESHIFT) == files


def test_a_file_that_is_not_there_is_made_once(tmp_path):
    path = str(tmp_path / "token")
    token = read_or_make_token(path, "token_file")
    assert len(token) == 16
    assert stat.S_IMODE(os.stat(path).st_mode) == 0o600
    assert read_or_make_token(path, "token_file") == read_token(path, "token_file") == token
    assert os.listdir(tmp_path) == ["token"]
    assert read_or_make_token(str(tmp_path / "other"), "token_file") != token


@pytest.mark.parametrize("text", ["sesame", "sesame\n", "  sesame\r\n"])
def test_a_token_of_ones_own_is_taken(tmp_path, text):
    assert read_or_make_token(write(tmp_path / "token", text), "token_file") == "sesame"


def test_a_tilde_is_the_users_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    token = read_or_make_token("~/token", "token_file")
    assert (tmp_path / "token").read_text() == f"{token}\n"


@pytest.mark.parametrize(
    ("text", "mode", "said"),
    [
        ("sesame", 0o644, r"token_file: others may read '.*token' \(mode 0644\); delete it"),
        ("sesame", 0o640, r"others may read .* \(mode 0640\)"),
        ("sesame", 0o602, r"others may read .* \(mode 0602\)"),
        ("", 0o600, "holds no token: one word of letters"),
        ("open sesame", 0o600, "holds no token"),
        ("sesame\nteacher", 0o600, "holds no token"),
        (b"\xff\xfe", 0o600, "holds no token"),
        ("a" * 2000, 0o600, "holds no token"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused_and_not_shown(tmp_path, text, mode, said):
    path = write(tmp_path / "token", text, mode)
    with pytest.raises(ConfigError, match=said) as error:
        read_or_make_token(path, "token_file")
    assert "sesame" not in str(error.value)
    assert os.listdir(tmp_path) == ["token"]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("folder", "is no file"),
        ("pipe", "is no file"),
        ("no/such/folder", "cannot be made: No such file or directory"),
        ("nul\0", "cannot be read: embedded null byte"),
    ],
)
def test_what_is_no_file_is_refused(tmp_path, name, said):
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe", 0o600)
    with pytest.raises(ConfigError, match=said):
        read_or_make_token(f"{tmp_path}/{name}", "token_file")


def test_a_relative_path_is_refused():
    with pytest.raises(ConfigError, match="'token' is no absolute path"):
        read_or_make_token("token", "token_file")


def test_another_users_file_is_refused(tmp_path, monkeypatch):
    path = write(tmp_path / "token")
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    with pytest.raises(ConfigError, match="belongs to another user"):
        read_token(path, "token_file")


def test_two_tokens_must_differ(tmp_path):
    path = write(tmp_path / "token")
    assert read_tokens({"token_file": path}, "/b") == Tokens("sesame", "")
    both = {"token_file": path, "instructor_token_file": path}
    with pytest.raises(ConfigError, match="/b: token_file and instructor_token_file hold the same"):
        read_tokens(both, "/b")


@pytest.mark.parametrize("kind", [RosbridgeConfig, VideoServerConfig])
@pytest.mark.parametrize("name", ["token", "instructor_token"])
def test_a_token_among_the_parameters_is_refused_and_not_shown(kind, name):
    with pytest.raises(ConfigError) as error:
        read_server_config(kind, {name: "sesame"}, "/b")
    assert str(error.value).startswith(f"parameter /b/{name} is not taken any more")
    assert f"give {name}_file" in str(error.value)
    assert "sesame" not in str(error.value)
