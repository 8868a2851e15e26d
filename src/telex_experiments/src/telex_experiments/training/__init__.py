"""The training on a station: what recording costs, and the time that "again" takes."""
