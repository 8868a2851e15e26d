"""A process in which what comes from outside is tried first."""
