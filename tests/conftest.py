"""Hypothesis looks at the same examples each time, so that a green suite stays green; and nobody's ``$OCIO`` is used.

Other examples are tried with ``pytest --hypothesis-profile=default``.
"""

import os

from hypothesis import settings

os.environ.pop("OCIO", None)  # a test that wants one sets it
settings.register_profile("steady", derandomize=True, deadline=None)
settings.load_profile("steady")
