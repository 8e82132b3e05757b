"""Following the flow and sampling pictures along it: streamlines, sample coordinates, samples."""
