"""Stands in for ROS 2's package look-up, which PyPI's xacro asks for $(find PACKAGE)."""
