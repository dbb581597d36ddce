"""Measurements of a phone held still."""
