"""Walks of a run computed once more and packed for the report, where a reader plays them."""

MOST_WALKS = 10
"""In a report, unless asked for otherwise."""
