"""The teleoperation nodes: topics, services and parameters."""
