"""Read and write pictures, and find the frames of a sequence."""
