"""Rates, intervals and tests, and the numbers that the paper prints."""
