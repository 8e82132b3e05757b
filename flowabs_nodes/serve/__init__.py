"""A local process that filters pictures for hosts: compositors, Blender, other programs (docs/serve.md).

Hosts send requests, and pictures through memory that both see, and get pictures back. The server runs nothing but
sessions of :mod:`flowabs_nodes.engine.session`; it writes no file, and is on no network unless it is asked to be.
"""
