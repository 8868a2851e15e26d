"""The guard of XML-RPC servers, under the name that programs import."""

from .ros.rospy_fixes.xmlrpc_guard import *  # noqa: F403
from .ros.rospy_fixes.xmlrpc_guard import __all__  # noqa: F401
