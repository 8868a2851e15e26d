"""The base class of controllers, under the name that programs import."""

from .manager.controller import *  # noqa: F403
from .manager.controller import __all__  # noqa: F401
