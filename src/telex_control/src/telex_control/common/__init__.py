"""Parameters, files, figures and processes: what every part of the workspace needs."""
