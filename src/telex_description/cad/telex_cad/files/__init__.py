"""Files that the generator writes: meshes and xacro."""
