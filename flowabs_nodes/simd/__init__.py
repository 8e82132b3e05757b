"""Sixteen pixels at a time: vectors as numba values, how kernels are compiled, and rows shared among threads."""
