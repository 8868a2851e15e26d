"""Parametric solids of the Telex robot: visual meshes, collision hulls and mass properties.

A development dependency only: `scripts/generate_model` writes what it makes into the package.
"""
