"""Handles and interfaces of hardware, under the name that programs import."""

from .hardware.hardware_interface import *  # noqa: F403
from .hardware.hardware_interface import __all__  # noqa: F401
