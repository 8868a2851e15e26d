"""Names that README and documents tell programs to import keep their places."""

from __future__ import annotations

import importlib

import pytest

PUBLIC = {
    "telex_control.controller": ("Controller", "ControllerState"),
    "telex_control.hardware_interface": ("EffortJointInterface", "JointHandle", "RobotHW"),
    "telex_control.kinematics": ("Chain", "Goal", "IKOptions", "IKSolver", "Tolerance", "dh_chain"),
    "telex_control.node_start": ("init_node",),
    "telex_control.urdf_joints": ("UrdfJoint", "parse_urdf"),
    "telex_control.xmlrpc_guard": ("guard_xmlrpc",),
}


@pytest.mark.parametrize("module", PUBLIC)
def test_a_public_module_offers_its_names(module):
    found = importlib.import_module(module)
    for name in PUBLIC[module]:
        assert name in found.__all__
        assert getattr(found, name) is not None
