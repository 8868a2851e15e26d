"""Textures: picture files, and pictures that are drawn by code."""
