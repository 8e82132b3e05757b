"""Finishing: the last steps of a picture, each pixel on its own, in one pass with decoding it.

``deferred.py`` notes operations down (:func:`~flowabs_nodes.finishing.deferred.with_operation`), ``operations.py`` says
what an operation is, ``fused.py`` does ours in one kernel, and ``in_bands.py`` any others, band by band of rows.
"""
