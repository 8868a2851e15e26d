"""The line between console and robot: delay, loss and outages; without ROS, asyncio or a clock."""
