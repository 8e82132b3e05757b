"""``python -m flowabs_nodes``: the command line."""

from flowabs_nodes.cli import script

script()
