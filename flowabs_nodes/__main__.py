"""``python -m flowabs_nodes``: the command line."""

import sys

from flowabs_nodes.cli import main

sys.exit(main())
