"""Measurements beside the suites: cost of a beep, real traces, errata."""
