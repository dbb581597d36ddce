"""Runs on disk: computing cells, storing them, reading them back."""

EXECUTORS = ("serial", "local", "dask")
"""Where cells may be computed, see `benchmarks.runs.executors`."""
