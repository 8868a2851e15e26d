from __future__ import annotations

import sys
import textwrap

import pytest
from std_msgs.msg import Float64

from telex_control.controllers import controller_class, type_names
from telex_control.hardware.hardware_interface import EffortJointInterface
from telex_control.manager.controller import Controller, ControllerInitError

MODULE = '''
from std_msgs.msg import Float64

from telex_control.controller import Controller
from telex_control.hardware_interface import EffortJointInterface


class SpringController(Controller):
    """Pulls a joint to a position like a spring."""

    parameters = frozenset(("joint", "stiffness"))

    def init(self, hw, root, node):
        self.joint = hw.get(EffortJointInterface).get_handle(node.param("joint", str))
        self.stiffness = node.param("stiffness", float, 10.0)
        self.target = 0.0
        node.subscribe("command", Float64, self.on_command)

    def on_command(self, message):
        self.target = message.data

    def starting(self, time):
        self.target = self.joint.state.position

    def update(self, time, period):
        self.joint.command = self.stiffness * (self.target - self.joint.state.position)

    def stopping(self, time):
        self.joint.command = 0.0


class NoController:
    pass
'''


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A user's package ``my_robot`` on the path, with the module ``spring``."""
    folder = tmp_path / "my_robot"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "spring.py").write_text(textwrap.dedent(MODULE))
    (folder / "needy.py").write_text("import a_module_that_nobody_has\n")
    (folder / "broken.py").write_text("raise RuntimeError('no licence')\n")
    (folder / "ending.py").write_text("raise SystemExit(3)\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield folder
    for name in [name for name in sys.modules if name.split(".")[0] == "my_robot"]:
        del sys.modules[name]


def test_a_user_s_own_controller_is_found_by_its_path(bench, package):
    tested = bench(
        {"c": {"type": "my_robot.spring.SpringController", "joint": "elbow", "stiffness": 4}}
    )
    tested.hw.states["elbow"].position = 0.5
    tested.load_and_start("c")
    info, _ = tested.manager.list_controllers()[0]
    assert info.type == "my_robot.spring.SpringController"
    assert info.claimed_resources[0].resources == ("elbow",)
    tested.node.advertise("c/command", Float64).publish(Float64(1.5))
    tested.cycle()
    handle = tested.hw.get(EffortJointInterface).get_handle("elbow")
    assert handle.command == pytest.approx(4.0)
    assert tested.switch(stop=["c"])
    assert handle.command == 0.0


def test_a_changed_controller_is_reloaded(bench, package):
    tested = bench({"c": {"type": "my_robot.spring.SpringController", "joint": "elbow"}})
    assert tested.manager.load_controller("c")
    source = package / "spring.py"
    source.write_text(source.read_text().replace("self.stiffness *", "1000.0 *"))
    assert tested.manager.reload_controller_libraries(True)
    tested.load_and_start("c")
    tested.node.advertise("c/command", Float64).publish(Float64(1.0))
    tested.cycle()
    assert tested.hw.get(EffortJointInterface).get_handle("elbow").command == 1000.0


def test_a_module_that_ends_the_program_when_it_is_reloaded_ends_nothing(bench, package, caplog):
    tested = bench({"c": {"type": "my_robot.spring.SpringController", "joint": "elbow"}})
    assert tested.manager.load_controller("c")
    (package / "spring.py").write_text("raise SystemExit(3)  # of another size\n")
    assert not tested.manager.reload_controller_libraries(True)
    assert "Could not reload the module my_robot.spring" in caplog.text


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("no_robot.spring.SpringController", "no Python module 'no_robot'"),
        ("my_robot.autumn.SpringController", "no Python module 'my_robot.autumn'"),
        ("my_robot.spring.AutumnController", "'my_robot.spring' has no class 'AutumnController'"),
        ("my_robot.spring.NoController", "no subclass"),
        ("my_robot.spring.Float64", "no subclass"),
        ("my_robot.needy.SpringController", "needs 'a_module_that_nobody_has'"),
        ("my_robot.broken.SpringController", "raised RuntimeError.*no licence"),
        ("my_robot.ending.SpringController", "raised SystemExit.*: 3"),
        ("SpringController", "list_controller_types"),
        ("my_robot/SpringController", "list_controller_types"),
        ("effort_controllers/JointPostionController", "list_controller_types"),
        ("", "list_controller_types"),
        (".SpringController", "list_controller_types"),
    ],
)
def test_what_is_wrong_with_a_path_is_said(package, path, message):
    with pytest.raises(ControllerInitError, match=message):
        controller_class(path)


def test_every_type_of_this_package_is_there():
    assert len(type_names()) == 21
    for name in type_names():
        found = controller_class(name)
        assert issubclass(found, Controller)
        assert found.__doc__
