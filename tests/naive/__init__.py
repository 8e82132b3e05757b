"""The paper's equations computed literally, in float64: slow, and plain enough to be checked against the page."""
