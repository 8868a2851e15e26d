"""Optics of a camera: pinhole, lens, exposure, noise of the sensor."""
