"""The guard of XML-RPC servers, under the name that programs import."""

from .ros.xmlrpc_guard import *  # noqa: F403
from .ros.xmlrpc_guard import __all__  # noqa: F401
