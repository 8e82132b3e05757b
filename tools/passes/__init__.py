"""Measure lines that are drawn from render passes, and how steady they are in motion; show sequences as pictures.

``python -m tools.passes -h`` lists what there is. Lines are (H, W), 1 paper and 0 ink; ink is 1 - lines.
"""
