"""What the operator's browser speaks with: the video server, the rosbridge and what both share."""
