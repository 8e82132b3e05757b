"""The gallery and the benchmark: tools of a checkout, not in the wheel."""
