"""Buildings and what stands in them."""
