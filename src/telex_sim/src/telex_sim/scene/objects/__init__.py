"""Objects of a scene as PyBullet bodies, with their latches and mechanisms."""
