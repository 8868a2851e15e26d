from __future__ import annotations

import pytest

from telex_control.common.params import ConfigError, read_config
from telex_control.ros.local_node_handle import LocalNodeHandle
from telex_control.urdf.joints import UrdfError, parse_urdf
from telex_sim.engine.simulator_config import (
    HardwareConfig,
    JointHardware,
    TimingConfig,
    read_simulator_config,
)
from telex_sim.engine.world import World, WorldError
from telex_sim.offline.simulation import shipped_config
from telex_sim.robot.robot_hw_sim import RobotHWSim


def test_the_shipped_configuration_is_valid():
    config = shipped_config()
    assert config.timing.steps_per_cycle == 1
    assert len(config.tracks.belts) == 4
    assert "turret_joint" in config.start.joint_positions()


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"timing__control_period": 0.003}, "got 0.003 s and 0.002 s"),
        ({"timing__control_period": 0.0}, "whole multiple"),
        ({"timing__step_size": 0.0}, "step_size is 0.0"),
        ({"timing__step_size": float("nan")}, "timing/step_size is nan"),
        ({"timing__real_time_factor": -1.0}, "real_time_factor is -1.0"),
        ({"timing__real_time_factor": 1e-6}, "step_size of 0.002 s it must be 0, for as fast as"),
        (
            {
                "timing__real_time_factor": 0.2,
                "timing__step_size": 0.05,
                "timing__control_period": 0.05,
            },
            "real_time_factor is 0.2; with a step_size of 0.05 s it must be 0, for as fast as "
            "possible, or at least 0.25",
        ),
        ({"timing__realtime_priority": 100}, "realtime_priority is 100; it must be at least 0"),
        ({"start__pose": "handstand"}, "pose is 'handstand'; there are: drive"),
        ({"start__default_pose": "handstand"}, "default_pose is 'handstand'; there are: drive"),
        ({"start__height": -0.1}, "height is -0.1"),
        ({"tracks__friction": 0.0}, "friction is 0.0"),
        ({"tracks__belts": {"x": -1.0}}, "belts/x is -1.0"),
        *(
            ({"tracks__belts": {"x": radius}}, f"belts/x is {radius} m; a radius of 0.001 to 10 m")
            for radius in (1e-200, 1e200)
        ),
        *(
            ({f"tracks__{name}": value}, f"{name} is {value}; it must be at least {least} and")
            for names, least in (
                (("friction", "lateral_friction", "side_friction"), "1e-06"),
                (("stiffness", "damping", "contact_stiffness", "contact_damping"), "1"),
            )
            for name in names
            for value in (1e-200, 1e200)
        ),
        ({"hardware__joints": {"turret_joint": {"armature": -0.1}}}, "armature is -0.1"),
        ({"hardware__joints": {"turret_joint": {"overtravel": -0.1}}}, "overtravel is -0.1"),
        ({"hardware__contacts": {"x": {"friction": -1.0}}}, "contacts/x: friction is -1.0"),
        ({"hardware__contacts": {"x": {"anchor": True}}}, "contacts/x/anchor is unknown"),
        ({"hardware__velocity_tolerance": 0.5}, "velocity_tolerance is 0.5"),
        ({"publish__clock_rate": 0.0}, "clock_rate is 0.0"),
        *(
            ({name: 1e-310}, "rate is 1e-310; it must be at least 0.001")
            for name in (
                "publish__clock_rate",
                "publish__poses_rate",
                "publish__base_pose_rate",
                "publish__stability_rate",
                "publish__truth_rate",
                "dosimetry__rate",
                "gas__rate",
            )
        ),
        *(
            (
                {f"{name}__rate": 1e-310},
                f"{name}: rate is 1e-310; it must be 0, for never, or at least 0.001",
            )
            for name in ("radio", "proximity", "gripper_contact")
        ),
        ({"solver_iterations": 0}, "solver_iterations is 0"),
        ({"world": ""}, "world is ''"),
        ({"colour": "red"}, "colour is unknown"),
    ],
)
def test_mistakes_are_named(change, named):
    with pytest.raises(ConfigError) as caught:
        shipped_config(**change)
    assert named in str(caught.value)


@pytest.mark.parametrize(("factor", "step"), [(0.01, 0.002), (0.005, 0.001), (0.0, 0.05)])
def test_no_step_has_to_wait_for_long(factor, step):
    timing = {"step_size": step, "control_period": step, "real_time_factor": factor}
    assert read_config(TimingConfig, timing, "timing").real_time_factor == factor


def test_the_node_names_its_parameters_as_they_are_called():
    with pytest.raises(ConfigError, match="^parameter /telex/simulator: world is ''"):
        read_simulator_config({"world": "", "paused": True}, "/telex/simulator")


@pytest.mark.parametrize(
    ("change", "priority"),
    [
        ({}, 1),
        ({"timing__realtime_priority": 7, "timing__real_time_factor": 0.5}, 7),
        ({"timing__realtime_priority": 0}, 0),
        ({"timing__real_time_factor": 0.0}, 0),
        ({"timing__real_time_factor": 1.5}, 0),
        ({"gui": True}, 0),
    ],
)
def test_only_a_loop_that_rests_comes_first(change, priority):
    assert shipped_config(**change).realtime_priority == priority


def robot(interface="hardware_interface/EffortJointInterface", limit='velocity="1" effort="1"'):
    return parse_urdf(
        '<robot name="r"><link name="a"/><link name="b"/><joint name="j" type="continuous">'
        f'<parent link="a"/><child link="b"/><limit {limit}/></joint><transmission name="t">'
        "<type>transmission_interface/SimpleTransmission</type>"
        f'<joint name="j"><hardwareInterface>{interface}</hardwareInterface></joint>'
        '<actuator name="m"><mechanicalReduction>1</mechanicalReduction></actuator>'
        "</transmission></robot>"
    )


@pytest.mark.parametrize(
    ("description", "config", "named"),
    [
        (robot(interface="hardware_interface/JointModeInterface"), HardwareConfig(), "simulated"),
        (robot(limit='velocity="0" effort="1"'), HardwareConfig(), "'j': max_velocity is 0.0"),
        (robot(), HardwareConfig(joints={"nose": JointHardware()}), "hardware/joints/nose"),
    ],
)
def test_hardware_that_cannot_be_simulated_is_named(description, config, named):
    hw = RobotHWSim(description, config)
    with pytest.raises(UrdfError, match=named):
        hw.init(LocalNodeHandle(), LocalNodeHandle())


def test_world_refuses_what_it_cannot_load(monkeypatch):
    world = World(0.002, 50)
    try:
        with pytest.raises(WorldError, match="no joint 'nose'"):
            world.load_robot(
                '<robot name="r"><link name="a"><inertial><mass value="1"/>'
                '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
                "</robot>",
                str,
                (0, 0, 0),
                0.0,
                {"nose": 1.0},
            )

        def unknown(address):
            raise ValueError(f"'{address}': package 'x' is not found")

        with pytest.raises(WorldError, match="package 'x' is not found"):
            world.load_robot(
                '<robot name="r"><link name="a"><collision><geometry>'
                '<mesh filename="package://x/y.obj"/></geometry></collision></link></robot>',
                unknown,
                (0, 0, 0),
                0.0,
                {},
            )
    finally:
        world.close()


def test_a_window_without_a_display_is_refused(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    with pytest.raises(WorldError, match="DISPLAY"):
        World(0.002, 50, gui=True)
