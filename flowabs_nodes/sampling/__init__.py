"""Following the flow and reading pictures along it: streamlines, sample coordinates, samples."""
