"""Scenes: what they consist of, their files, the library of objects, their place in the world."""
