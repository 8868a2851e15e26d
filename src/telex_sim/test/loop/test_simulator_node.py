"""The simulator's node where something fails beside it: robots come and go, the loop goes on."""

from __future__ import annotations

import threading

import pytest
from own_ros import Topics
from waiting import wait_until

from telex_control.common.file_catalog import package_path
from telex_control.ros.run_memory import RunMemory
from telex_sim.engine.simulation import Simulation
from telex_sim.offline.simulation import shipped_config
from telex_sim.scene.addresses import resolve_address

pytestmark = [pytest.mark.ros, pytest.mark.slow]

SECOND = "/second"
HOT = "objects: [{type: source_capsule, position: [3.0, 0.0, 0.0], activity: 3.7e13}]\n"


class Station:
    """A simulator in this process, paused, whose loop has a thread of its own."""

    def __init__(self, urdf, folder, topics):
        from std_srvs.srv import Empty
        from telex_msgs.srv import AddRobot, LoadScene, RemoveRobot

        from telex_control.ros.ros_node_handle import RosNodeHandle
        from telex_sim.ros.crash_recovery import CrashRecovery
        from telex_sim.ros.simulator_node import SimulatorNode

        self.simulation = Simulation(
            shipped_config(world="floor", timing__realtime_priority=0),
            urdf,
            RosNodeHandle("/telex"),
            lambda address: resolve_address(address, package_path),
        )
        # The one before has crashed, while a further robot was stopped.
        memory = RunMemory(str(folder / "memory.json"))
        memory.keep(steps=0, e_stop=False, resets=0, stopped=[SECOND])
        recovery = CrashRecovery(memory)
        recovery.restore(self.simulation)
        self.node = SimulatorNode(self.simulation, recovery, paused=True)
        self.loop = threading.Thread(target=self.node.run, name="loop")
        self.loop.start()
        self.add = topics.calls("/sim/add_robot", AddRobot)
        self.remove = topics.calls("/sim/remove_robot", RemoveRobot)
        self.load_scene = topics.calls("/sim/load_scene", LoadScene)
        self.reset = topics.calls("/sim/reset", Empty)

    @property
    def models(self):
        return [robot.model for robot in self.simulation.robots]


@pytest.fixture
def station(master, urdf, tmp_path, monkeypatch):
    import rospy

    rospy.set_param(f"{SECOND}/robot_description", urdf)
    rospy.set_param(f"{SECOND}/simulation", {"model": "second", "start": {"place": [0, 2, 0.2, 0]}})
    ended = threading.Event()
    with Topics("") as topics:
        made = Station(urdf, tmp_path, topics)
        with monkeypatch.context() as patch:
            patch.setattr(rospy, "is_shutdown", ended.is_set)
            yield made
            assert made.loop.is_alive()
            ended.set()
            wait_until(lambda: not made.loop.is_alive(), "the end of the loop")
        made.node.close()


def test_a_robot_whose_topics_cannot_be_opened_is_taken_out_again(station, monkeypatch):
    from rospy import ServiceException

    from telex_sim.ros import simulator_node

    def fail(*_):
        raise OSError("the master is gone")

    with monkeypatch.context() as patch:
        patch.setattr(simulator_node, "RobotPresence", fail)
        with pytest.raises(ServiceException, match="the master is gone"):
            station.add(SECOND)
    assert station.models == ["telex"]
    assert station.add(SECOND).success
    assert station.models == ["telex", "second"]
    assert station.simulation.robots[1].e_stop_wanted
    assert station.remove(SECOND).success
    assert station.models == ["telex"]


def test_cameras_are_looked_for_at_each_start_and_never_by_the_loop(station, monkeypatch):
    import rospy

    get_param, asked = rospy.get_param, []

    def noted(name, *default):
        asked.append((name, threading.current_thread()))
        return get_param(name, *default)

    monkeypatch.setattr(rospy, "get_param", noted)
    assert station.add(SECOND).success
    for start in (lambda: station.load_scene(HOT), station.reset):
        asked.clear()
        start()
        names = [name for name, _ in asked]
        assert names == ["/telex/cameras/cameras", f"{SECOND}/cameras/cameras"]
        assert station.loop not in [thread for _, thread in asked]
