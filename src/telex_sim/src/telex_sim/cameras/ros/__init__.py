"""The ``cameras`` node: scene and poses in, pictures out."""
