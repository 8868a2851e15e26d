"""An experiment's surroundings: a ROS master of its own, the simulator, a folder, a seed."""

from __future__ import annotations

import os
import zlib
from pathlib import Path
from typing import Any, Callable, Sequence, Union

import numpy as np
import rospy
import simplejpeg
import yaml
from sensor_msgs.msg import CompressedImage
from telex_msgs.msg import SceneDescription
from telex_msgs.srv import ConfigureCamera

from telex_control.ros.rospy_fixes.connecting import miss_nothing
from telex_experiments.rigs.private_master import PrivateMaster

from .recorder import PICTURES, Recorder
from .simulator import Argument, Simulator

_LOOK_TIMEOUT = 120.0  # s of wall time, for a machine that has other things to do


class PaperSession:
    """One experiment's workplace; use it as a context manager.

    rospy can be initialised once in a process only: there is one session in each.

    Parameters
    ----------
    name : str
        Of the experiment.
    folder : Path
        Of its results; it exists.
    quick : bool
        Whether a coarse answer is asked for.
    seed : int
        Of all that is random.
    say : callable
        Takes a line of progress.
    repeat : int
        Runs of an experiment that is `repeatable`.

    Attributes
    ----------
    namespace : str
        Of the robot.
    log : Path
        What the started programs print.
    """

    namespace = "/telex"

    def __init__(
        self,
        name: str,
        folder: Path,
        quick: bool,
        seed: int,
        say: Callable[[str], None],
        repeat: int = 1,
    ) -> None:
        self.name = name
        self.folder = folder
        self.quick = quick
        self.seed = seed
        self.say = say
        self.repeat = repeat
        self.log = folder / "log.txt"
        self._master = PrivateMaster()

    def __enter__(self) -> PaperSession:
        self._master.__enter__()
        # rosrun, roslaunch and whatever else is started from here is to meet this master only.
        os.environ.update(self._master.environment())
        os.environ.pop("ROS_NAMESPACE", None)
        rospy.set_param("/use_sim_time", True)
        miss_nothing()
        rospy.init_node(f"paper_{self.name}", disable_signals=True)
        return self

    def __exit__(self, *exception: object) -> None:
        rospy.signal_shutdown("done")
        self._master.__exit__()

    def rng(self, *key: Union[str, int]) -> np.random.Generator:
        """Return a generator of random numbers for this experiment and a key, by the seed."""
        words = [zlib.crc32(str(each).encode()) for each in (self.name, *key)]
        return np.random.default_rng([self.seed, *words])

    def simulator(self, **arguments: Argument) -> Simulator:
        """Return the simulator, to be entered; arguments are those of ``bringup.launch``."""
        return Simulator(self._master, self.log, **arguments)

    def record(
        self,
        name: str,
        cameras: Sequence[str] = (),
        topics: Sequence[str] = (),
        rate: float = PICTURES,
        watched: bool = False,
    ) -> Recorder:
        """Return a recorder, to be entered, that writes ``<name>.bag``; see `Recorder`.

        The cameras are drawn as often as they are recorded from then on, and none before another:
        more would take the processor from the physics and from what leads the robot. Where somebody
        else watches them (`watched`), they stay as they are.
        """
        for camera in () if watched else cameras:
            self.configure_camera(camera, rate=rate, priority=0)
        return Recorder(
            self.folder / f"{name}.bag", self.namespace, self.log, topics, cameras, rate
        )

    def configure_camera(self, camera: str, **settings: Any) -> None:
        """Have a camera drawn otherwise, by its settings in ``cameras.yaml``.

        Raises
        ------
        rospy.ROSException
            The service does not come up.
        RuntimeError
            It refuses them.
        """
        name = f"{self.namespace}/cameras/configure"
        rospy.wait_for_service(name, _LOOK_TIMEOUT)
        parameters = yaml.safe_dump(settings, default_flow_style=True)
        answer = rospy.ServiceProxy(name, ConfigureCamera)(camera=camera, parameters=parameters)
        if not answer.success:
            raise RuntimeError(f"{name}: {answer.message}")

    def look(self, camera: str) -> np.ndarray:
        """Return the next picture of a camera: RGB, uint8, shape (height, width, 3).

        Raises
        ------
        rospy.ROSException
            None came within two minutes.
        """
        message = self.wait_for(f"cameras/{camera}/image_raw/compressed", CompressedImage)
        return simplejpeg.decode_jpeg(message.data, colorspace="RGB")

    def scene(self) -> SceneDescription:
        """Return what the scene consists of: its frames and their shapes."""
        return self.wait_for("sim/scene", SceneDescription)

    def wait_for(self, topic: str, kind: Any, timeout: float = _LOOK_TIMEOUT) -> Any:
        """Return the next message on a topic, named relative to the robot's namespace.

        Raises
        ------
        rospy.ROSException
            None came within `timeout` (s of wall time).
        """
        return rospy.wait_for_message(f"{self.namespace}/{topic}", kind, timeout)
