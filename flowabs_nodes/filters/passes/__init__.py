"""Lines and mattes from a render's passes: depth, normals, ids."""
