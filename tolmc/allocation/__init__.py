"""The decision: the cheapest tolerances that keep the required share of the motions within limits."""
