"""Commands that score and export recordings."""
