"""rosbridge v2 over WebSocket: ROS topics, services and parameters as JSON."""
