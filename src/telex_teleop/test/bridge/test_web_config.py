"""Parameters of the two servers, and the address that they listen on."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest
import yaml

from telex_control.common.params import ConfigError
from telex_teleop.web import serving
from telex_teleop.web.listening import BindError, bind, url_of
from telex_teleop.web.rights import Rights
from telex_teleop.web.server_config import RosbridgeConfig, VideoServerConfig, read_server_config
from telex_teleop.web.tokens import is_loopback

PACKAGE = Path(__file__).resolve().parents[2]


def test_defaults_without_parameters():
    config = read_server_config(VideoServerConfig, {}, "/telex/video_server")
    assert (config.address, config.port) == ("127.0.0.1", 8080)
    assert read_server_config(RosbridgeConfig, {}, "/telex/rosbridge").port == 9090


@pytest.mark.parametrize(
    ("config_class", "name"), [(VideoServerConfig, "video_server"), (RosbridgeConfig, "rosbridge")]
)
def test_the_config_file_holds_every_parameter_with_its_default(config_class, name):
    values = yaml.safe_load((PACKAGE / "config" / f"{name}.yaml").read_text())
    assert read_server_config(config_class, values, name) == config_class()
    assert set(values) == set(vars(config_class()))


def test_values_are_taken_and_own_parameters_ignored():
    values = {"port": 0, "stall_timeout": 2, "url": "http://127.0.0.1:1"}
    config = read_server_config(VideoServerConfig, values, "/v")
    assert config.port == 0
    assert config.stall_timeout == 2.0
    bridge = read_server_config(RosbridgeConfig, {"allowed_origins": ["null"]}, "/b")
    assert bridge.allowed_origins == ("null",)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"port": 70000}, "parameter /v: port is 70000; it must be at least 0 and at most 65535"),
        ({"port": "8080"}, "parameter /v/port is '8080'; an integer is needed"),
        ({"port": True}, "parameter /v/port is True; an integer is needed"),
        ({"quality": 0}, "parameter /v: quality is 0; it must be at least 1"),
        (
            {"default_stream_type": "vp8"},
            "parameter /v: default_stream_type is 'vp8'; mjpeg, ros_compressed, png are possible",
        ),
        ({"main_rate": 0}, "parameter /v: main_rate is 0.0; it must be at least 0.1"),
        ({"stall_timeout": float("nan")}, "parameter /v/stall_timeout is nan; it must be finite"),
        ({"stall_timeout": 0.4}, "parameter /v: stall_timeout is 0.4; it must be at least 0.5"),
        ({"address": ""}, "parameter /v: address is ''; it must not be empty"),
        ({"prot": 1}, "parameter /v/prot is unknown; known are actions, address"),
        ("x", "parameter /v is 'x'; a struct is needed"),
    ],
)
def test_bad_values_are_refused_by_name(values, said):
    with pytest.raises(ConfigError) as error:
        read_server_config(VideoServerConfig, values, "/v")
    assert str(error.value).startswith(said)


def test_a_list_of_origins_must_be_a_list_of_strings():
    with pytest.raises(ConfigError, match="/b/allowed_origins is 'a'; a list is needed"):
        read_server_config(RosbridgeConfig, {"allowed_origins": "a"}, "/b")
    with pytest.raises(ConfigError, match=r"/b/allowed_origins\[1\] is 1; a string is needed"):
        read_server_config(RosbridgeConfig, {"allowed_origins": ["a", 1]}, "/b")


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"max_command_age": 0}, "max_command_age is 0.0; it must be at least 0.01"),
        ({"plain": True, "address": "0.0.0.0"}, "plain is true and address '0.0.0.0'; a bridge"),
    ],
)
def test_who_may_do_what_is_checked(values, said):
    with pytest.raises(ConfigError) as error:
        read_server_config(RosbridgeConfig, values, "/b")
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("operator: {publish: [a b]}", "operator: publish holds 'a b'; a pattern is a ROS name"),
        ("commands: {call: ['']}", "commands: call holds ''; a pattern is a ROS name"),
        ("commands: {sing: []}", "commands/sing is unknown; known are call, get, publish, serve"),
        ("instructor: {set: '*'}", "instructor/set is '*'; a list is needed"),
        ("operators: {}", "operators is unknown; known are commands, instructor, operator"),
        ("[", "cannot be read: "),
    ],
)
def test_a_wrong_file_of_rights_is_refused_by_name(tmp_path, text, said):
    file = tmp_path / "rights.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError) as error:
        Rights.read(str(file))
    assert str(error.value).startswith(f"{file}: ")
    assert said in str(error.value)


def test_the_bridge_shows_operators_no_camera_that_the_video_server_hides():
    subscribe = Rights.read().operator.subscribe
    for camera in VideoServerConfig().hidden_cameras:
        assert f"!/*cameras/{camera}/*" in subscribe


@pytest.mark.parametrize(
    ("address", "own"),
    [("127.0.0.1", True), ("localhost", True), ("::1", True), ("0.0.0.0", False), ("::", False)],
)
def test_addresses_that_only_this_machine_reaches(address, own):
    assert is_loopback(address) is own


def test_port_0_takes_a_free_port():
    with bind("127.0.0.1", 0, "/v") as listener:
        assert url_of("http", listener) == f"http://127.0.0.1:{listener.getsockname()[1]}"


def test_all_networks_are_announced_by_the_loopback_address():
    with bind("0.0.0.0", 0, "/v") as listener:
        assert url_of("ws", listener).startswith("ws://127.0.0.1:")


def test_a_port_in_use_is_named_with_its_remedy():
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with pytest.raises(BindError) as error:
            bind("127.0.0.1", port, "/telex/video_server")
    assert str(error.value) == (
        f"/telex/video_server/port: {port} on 127.0.0.1 is in use by another program; stop that "
        "program, or set the parameter to another port (0: any free one)"
    )


@pytest.mark.parametrize("address", ["203.0.113.7", "no such host", "a" * 300])
def test_an_address_of_another_machine_is_refused(address):
    with pytest.raises(BindError, match="/v/address: "):
        bind(address, 0, "/v")


@pytest.mark.parametrize("interrupted", ["get_param", "logfatal", "signal_shutdown"])
def test_an_interrupt_while_a_port_is_taken_is_no_traceback(monkeypatch, interrupted):
    with bind("127.0.0.1", 0, "/v") as taken:
        values = {"port": taken.getsockname()[1]}
        fakes = {
            "init_node": lambda *_args, **_kwargs: None,
            "get_name": lambda: "/v",
            "get_param": lambda name, default: values if name == "~" else default,
            "logfatal": lambda *_: None,
            "signal_shutdown": lambda _: None,
        }
        meant = fakes[interrupted]
        left = [KeyboardInterrupt()]

        def interrupt(*arguments):
            if left:
                raise left.pop()
            return meant(*arguments)

        fakes[interrupted] = interrupt
        for name, fake in fakes.items():
            monkeypatch.setattr(serving.rospy, name, fake)
        assert serving.run_node("v", "http", VideoServerConfig, lambda _: None) == 130
