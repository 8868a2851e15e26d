"""Beginning of an exercise in which the robot drives ahead; zones and steps are to follow."""

AHEAD = """
name: ahead
title: Ahead
description: Drive half a metre ahead.
scene: {lights: {sun: {azimuth: -2.4, elevation: 0.9}}}
begin: {not: {inside: {what: robot, zone: start}}}
zones:
  start: {center: [0.0, 0.0, 0.5], size: [0.3, 1.0, 1.2]}
"""
