"""The file of a class's stations: what is wrong in it is named, with what would be right."""

import os

import pytest

from telex_training.classroom.stations_file import StationsError, load_stations
from telex_training.command_lines.classroom import main

TWO = """
stations:
  - {name: left, address: "http://192.0.2.11:8080", token_file: tokens/left}
  - {name: "right 2", address: "http://127.0.0.1:8081"}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "tokens").mkdir()
    token = tmp_path / "tokens" / "left"
    token.write_text("sesame\n")
    token.chmod(0o600)
    return tmp_path


def load(folder, text):
    path = folder / "stations.yaml"
    path.write_text(text, encoding="utf-8")
    return load_stations(path)


def test_stations_come_with_their_tokens(folder):
    left, right = load(folder, TWO)
    assert (left.name, left.address, left.token) == ("left", "http://192.0.2.11:8080", "sesame")
    assert (right.name, right.token) == ("right 2", "")
    assert "sesame" not in repr(left)


def station(**changes):
    given = {"name": "a", "address": "http://127.0.0.1:8080", **changes}
    return f"stations: [{{{', '.join(f'{key}: {value}' for key, value in given.items())}}}]"


@pytest.mark.parametrize(
    "name",
    [
        "Prüfstand 1",
        "Pru\u0308fstand",  # a mark behind its letter
        "Élève_2",
        "станция 3",
        "第一組",
        "स्टेशन",
        "9",
        "x.-_",
        "ü" * 40,
    ],
)
def test_a_name_has_letters_of_any_script(folder, name):
    assert load(folder, station(name=f"'{name}'"))[0].name == name


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[]", "a struct with the key 'stations' is needed"),
        ("class: []", "class is unknown; known is stations"),
        ("stations: []", "stations is []; one station at least is needed"),
        ("stations: [{name: a}]", "stations[0]/address is missing"),
        (station(token="sesame"), "stations[0]/token is unknown; known are address, name"),
        (station(name="''"), "stations[0]: name is ''; 1 to 40 letters"),
        (station(name="a/b"), "name is 'a/b'; 1 to 40 letters"),
        *(
            (station(name=f'"{name}"'), "1 to 40 letters, digits, spaces and _ . - are possible")
            for name in (
                "ü" * 41,
                "ü ",
                " ü",
                "..",
                "_a",
                "\u0308u",
                "a\\tb",
                "a\\x07b",
                "a\u00a0b",
                "a\u200bb",
                "a\u202eb",
                "a\\\\b",
                "ü?",
                "<b>",
                "a%2Fb",
                "🙂",
            )
        ),
        (station(name="3"), "stations[0]/name is 3; a string is needed"),
        (station(address="127.0.0.1:8080"), "address is '127.0.0.1:8080'; http://HOST:PORT is"),
        (station(address="'http://127.0.0.1:8080/'"), "and nothing after it"),
        (station(address="'http://127.0.0.1'"), "http://HOST:PORT is needed"),
        (station(address="'http://127.0.0.1:99999'"), "http://HOST:PORT is needed"),
        (station(address="'http://a:b@127.0.0.1:80'"), "http://HOST:PORT is needed"),
        (station(address="'ftp://127.0.0.1:80'"), "http://HOST:PORT is needed"),
        (station(address="'http://192.0.2.1:80'"), "token_file is missing; 192.0.2.1 is another"),
        (station(token_file="none"), "is not there; a copy of the station's file"),
        (TWO.replace('"right 2"', "left"), "stations[1]/name is 'left'; stations[0] has it, too"),
        ("stations: [{name: a, name: b}]", "line 1"),
    ],
)
def test_what_is_wrong_is_named(folder, text, message):
    with pytest.raises(StationsError) as caught:
        load(folder, text)
    assert str(caught.value).startswith(f"{folder / 'stations.yaml'}: ")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("mode", "content", "message"),
    [(0o644, "sesame", "others may read"), (0o600, "two words", "holds no token")],
)
def test_a_file_of_a_token_is_private_and_holds_one(folder, mode, content, message):
    path = folder / "tokens" / "left"
    path.write_text(content)
    path.chmod(mode)
    with pytest.raises(StationsError, match=message) as caught:
        load(folder, TWO)
    assert "stations[0]: token_file" in str(caught.value)
    assert "sesame" not in str(caught.value)


class TestCommand:
    def test_a_file_is_checked(self, folder, capsys):
        path = folder / "stations.yaml"
        path.write_text(TWO)
        assert main([str(path), "--check"]) == 0
        assert "OK, 2 stations: left, right 2" in capsys.readouterr().out

    def test_what_cannot_be_served_is_said(self, folder, capsys):
        assert main([str(folder / "none.yaml")]) == os.EX_CONFIG
        assert "none.yaml: No such file" in capsys.readouterr().err
        path = folder / "stations.yaml"
        path.write_text(TWO)
        elsewhere = ["--address", "192.0.2.1", "--token-file", str(folder / "own")]
        assert main([str(path), *elsewhere]) == os.EX_CONFIG
        assert "192.0.2.1' is not an address of this machine" in capsys.readouterr().err
        with pytest.raises(SystemExit):
            main([str(path), "--port", "70000"])
        assert "0 to 65535" in capsys.readouterr().err
