"""What looks at pictures in motion: over the frames of a shot, or from frame to frame."""
