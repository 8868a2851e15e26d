"""Triangle meshes: their files, normals, materials, hulls and masses."""
