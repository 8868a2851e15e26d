"""Rig for the page of a class: stand-ins for stations, a live station, and the page."""
