#!/usr/bin/env python3
"""$(find xacro)/xacro and xacro.py of launch files: the xacro of the environment of env.sh."""

import os
import sys

os.execvp("xacro", ["xacro", *sys.argv[1:]])
