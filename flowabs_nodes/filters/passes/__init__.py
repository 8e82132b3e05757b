"""Lines from the passes of a render: depth, normals, ids."""
