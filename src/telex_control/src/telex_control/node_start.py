"""Start of nodes, under the name that programs import."""

from .ros.node_start import *  # noqa: F403
from .ros.node_start import __all__  # noqa: F401
