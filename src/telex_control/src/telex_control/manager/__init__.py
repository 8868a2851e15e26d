"""Controllers and their manager."""
