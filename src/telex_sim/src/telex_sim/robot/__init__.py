"""One simulated robot: its body, hardware, drives and sensors."""
