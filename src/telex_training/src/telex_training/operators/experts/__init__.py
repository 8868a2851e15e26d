"""One module for each kind of shipped exercise: how an expert does it. `catalog` has all."""
