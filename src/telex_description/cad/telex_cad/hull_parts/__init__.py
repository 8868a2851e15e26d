"""Parts of the hull."""
