"""Measurements of the operator's console with a browser before it."""
