"""Publishers of what sensors and equipment of a robot measure."""
