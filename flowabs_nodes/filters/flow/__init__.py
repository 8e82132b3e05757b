"""The edge tangent flow (section 2), and what shows it or follows it."""
