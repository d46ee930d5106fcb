"""Motions with one-sided contact: the wall pushes, it never pulls."""
