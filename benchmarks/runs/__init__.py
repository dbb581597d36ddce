"""Runs on disk: computing cells, storing them, reading them back."""
