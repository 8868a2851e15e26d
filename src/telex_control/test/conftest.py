from __future__ import annotations

import threading
from typing import Any, Dict, List

import pytest

from telex_control.hardware.hardware_interface import (
    EffortJointInterface,
    JointHandle,
    JointStateHandle,
    JointStateInterface,
    PositionJointInterface,
    RobotHW,
    VelocityJointInterface,
)
from telex_control.manager.controller_manager import ControllerManager
from telex_control.ros.local_node_handle import LocalNodeHandle

# The tests of this package import the modules that they share from this directory.

URDF = """
<robot name="bench">
  <link name="base"/><link name="a"/><link name="b"/><link name="c"/>
  <joint name="elbow" type="revolute"><parent link="base"/><child link="a"/>
    <limit lower="-1" upper="2" velocity="1.5" effort="10"/></joint>
  <joint name="slide" type="prismatic"><parent link="a"/><child link="b"/>
    <limit lower="0" upper="0.3" velocity="0.1" effort="100"/></joint>
  <joint name="wheel" type="continuous"><parent link="b"/><child link="c"/>
    <limit velocity="10" effort="5"/></joint>
</robot>
"""


class BenchHW(RobotHW):
    """Three joints without physics."""

    def __init__(self) -> None:
        super().__init__()
        self.states: Dict[str, JointStateHandle] = {
            name: JointStateHandle(name) for name in ("elbow", "slide", "wheel")
        }
        state_interface = JointStateInterface()
        interfaces = [EffortJointInterface(), VelocityJointInterface(), PositionJointInterface()]
        self.efforts: Dict[str, JointHandle] = {}
        for name, state in self.states.items():
            state_interface.register_handle(state)
            handles = [JointHandle(state) for _ in interfaces]
            for interface, handle in zip(interfaces, handles):
                interface.register_handle(handle)
            self.efforts[name] = handles[0]
        for interface in (state_interface, *interfaces):
            self.register_interface(interface)
        self.switches: List[Any] = []

    def read(self, time: float, period: float) -> None: ...

    def write(self, time: float, period: float) -> None: ...

    def do_switch(self, start, stop) -> None:
        self.switches.append(([c.name for c in start], [c.name for c in stop]))


class Bench:
    """A controller manager whose loop runs only while a call waits for it."""

    def __init__(self, params: Dict[str, Any]) -> None:
        params = {"robot_description": URDF, **params}
        self.node = LocalNodeHandle(params)
        self.hw = BenchHW()
        self.manager = ControllerManager(self.hw, self.node)
        self.time = 0.0
        self.period = 0.002

    def cycle(self, count: int = 1, **options: Any) -> None:
        for _ in range(count):
            self.manager.update(self.time, self.period, **options)
            self.time = round(self.time + self.period, 9)

    def switch(self, start=(), stop=(), strictness=2, **options: Any) -> bool:
        answer: List[bool] = []
        thread = threading.Thread(
            target=lambda: answer.append(
                self.manager.switch_controller(start, stop, strictness, **options)
            )
        )
        thread.start()
        while thread.is_alive():
            self.cycle()
            thread.join(0.001)
        return answer[0]

    def load_and_start(self, *names: str) -> List[Any]:
        for name in names:
            assert self.manager.load_controller(name)
        assert self.switch(start=names)
        return [self.manager.loaded[name].controller for name in names]

    def states(self) -> Dict[str, str]:
        return {info.name: state.value for info, state in self.manager.list_controllers()}


@pytest.fixture
def bench():
    return Bench


@pytest.fixture
def bench_urdf():
    return URDF
