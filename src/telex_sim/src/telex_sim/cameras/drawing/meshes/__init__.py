"""Meshes and textures in the memory of whatever renders, in groups that are drawn together."""
