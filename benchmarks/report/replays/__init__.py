"""Walks of a run computed once more and packed for the report, where a reader plays them."""
