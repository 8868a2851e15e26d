"""What is typed: scoring and exporting of recordings."""
