"""Parts of a trial that is under way, without topics and services of their own."""
