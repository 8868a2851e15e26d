"""Gamma radiation: nuclides, what shields against them, the field of sources, and doses."""
