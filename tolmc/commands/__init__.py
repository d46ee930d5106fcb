"""What the command line does: load, call, write."""
