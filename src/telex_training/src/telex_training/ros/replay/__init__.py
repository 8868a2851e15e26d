"""The node that draws recordings again, its pages and what draws for it."""
