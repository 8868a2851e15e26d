"""The operator's side: teleoperation nodes, keyboard, video server, bridge and console.

Everything here speaks ROS only; nothing knows that the robot is simulated.

The teleoperation nodes: `joint_nodes` (arm, gripper, flippers) and `ros_track_teleop` are where
they start, `ros_joint_teleop`, `ros_flipper_teleop` and `ros_common` the rest of their ROS edge.
Their core knows no ROS: `joint_teleop`, `coupled_teleop`, `flipper_teleop` and `track_drive` put
together `stream` (watchdog and latch of a command stream), `reference` and `axis` (how a reference
moves), `flipper_presets`, `joint_jog`, `speed`, `limits` and `e_stop_state`. `keyboard` is the
terminal, `web` the video server, the bridge and what serves the console.
"""
