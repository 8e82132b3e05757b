"""What makes the gallery and measures the speed: for a checkout, not in the wheel."""
