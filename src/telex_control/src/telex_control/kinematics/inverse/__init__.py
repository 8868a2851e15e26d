"""Inverse kinematics of one chain, inside the limits of its joints."""
