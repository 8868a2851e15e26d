"""The controller that the package's README shows."""

from __future__ import annotations

import re
from pathlib import Path

import yaml
from std_msgs.msg import Float64

README = Path(__file__).parents[2] / "README.md"


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README.read_text(), re.DOTALL)


def test_the_shown_controller_works(bench, tmp_path, monkeypatch):
    (source,) = blocks("python")
    (params,) = blocks("yaml")
    package = tmp_path / "my_package"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "my_module.py").write_text(source)
    monkeypatch.syspath_prepend(str(tmp_path))
    config = yaml.safe_load(params)
    config["spring_controller"]["joint"] = "elbow"
    tested = bench(config)
    tested.hw.states["elbow"].position = 0.5
    (spring,) = tested.load_and_start("spring_controller")
    tested.cycle()
    assert spring._joint.command == 0.0
    tested.node.advertise("spring_controller/command", Float64).publish(Float64(0.7))
    tested.cycle()
    assert abs(spring._joint.command - 20.0 * 0.2) < 1e-9
    assert tested.switch(stop=["spring_controller"])
    assert spring._joint.command == 0.0
    ((info, _),) = tested.manager.list_controllers()
    assert info.claimed_resources[0].resources == ("elbow",)
