"""Sealed cases of vehicles from a generator of their own, and how well they are diagnosed."""
