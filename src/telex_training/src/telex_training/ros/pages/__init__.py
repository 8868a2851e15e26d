"""Pages in a browser: sheets, briefs and progress, behind mounts of the video server."""
