"""Joints and limits of a URDF, under the name that programs import."""

from .urdf.joints import *  # noqa: F403
from .urdf.joints import __all__  # noqa: F401
