"""References and command streams: what all joints share."""
