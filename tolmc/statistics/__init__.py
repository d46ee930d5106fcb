"""What the samples of a run say, every estimate with its interval."""
