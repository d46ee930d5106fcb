"""Monte Carlo runs that survive, from drawing the samples to what the run directory holds."""
