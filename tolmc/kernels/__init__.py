"""Equations and integrators on plain float64 arrays; nothing here knows the rest of tolmc."""
