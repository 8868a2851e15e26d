"""Transforms for web clients, as tf2_web_republisher offers them."""
