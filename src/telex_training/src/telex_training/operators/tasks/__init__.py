"""Tasks that an operator does from begin to end, one a module."""
