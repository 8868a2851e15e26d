"""Messages and services of the controller manager, and `utils` to find it and its controllers."""
