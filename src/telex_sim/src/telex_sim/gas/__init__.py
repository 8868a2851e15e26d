"""Gas that leaks, and the sensor that smells it."""
