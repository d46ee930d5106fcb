"""Numbers and phrases as people read them, written once for terminal and report."""
