"""Bring recordings of other origin in as runs."""
