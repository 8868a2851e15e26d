"""Rigid geometry: rotations, poses, and the conversions between their forms.

`quaternions` has them as plain tuples, which is
faster for the few numbers of one cycle; `matrices` has them as numpy arrays. Messages of ROS are in
`telex_control.ros.pose_messages`. Only what cannot call these computes for itself: the compiled
kernels of the inverse kinematics, and PyBullet's and KDL's own transforms where their objects are
at hand anyway.

Quaternions are x, y, z, w throughout; roll, pitch and yaw are URDF's, about the fixed axes x, y and
z (rad).
"""
