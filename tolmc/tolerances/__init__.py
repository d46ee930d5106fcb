"""From dimensions with tolerances to samples of them."""
