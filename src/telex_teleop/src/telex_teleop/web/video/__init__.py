"""MJPEG video server with the interface of web_video_server; it also serves the console."""
