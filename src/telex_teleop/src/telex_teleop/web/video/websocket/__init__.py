"""``/video``: all cameras over one WebSocket."""
