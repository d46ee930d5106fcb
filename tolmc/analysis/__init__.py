"""Answers from few motions, and which tolerance matters."""
