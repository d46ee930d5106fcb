"""Equations of motion, a file a formulation."""
