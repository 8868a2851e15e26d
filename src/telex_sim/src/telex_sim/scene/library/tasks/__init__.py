"""Objects to work on: to be carried, turned, switched, plugged."""
