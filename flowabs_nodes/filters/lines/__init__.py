"""Line drawing (section 3): DoG, FDoG, its iterations, thresholds."""
