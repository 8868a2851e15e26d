"""Light of a scene: sky, sun and lamps, and their shadows."""
