"""The radio signal between a robot and its operator's antenna."""
