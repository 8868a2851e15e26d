"""Robot descriptions: elements, joints, limits, transmissions, wheels."""
