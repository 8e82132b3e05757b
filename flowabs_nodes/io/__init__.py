"""Pictures and sequences in and out of files."""
