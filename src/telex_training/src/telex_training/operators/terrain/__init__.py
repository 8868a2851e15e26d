"""One module for each kind of ground: how an operator passes it."""
