"""Hypothesis looks at the same examples each time, so that a green suite stays green.

Other examples are tried with ``pytest --hypothesis-profile=default``.
"""

from hypothesis import settings

settings.register_profile("steady", derandomize=True, deadline=None)
settings.load_profile("steady")
