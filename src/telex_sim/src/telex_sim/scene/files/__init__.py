"""Scene files: YAML that nobody has checked, and what is made of it."""
