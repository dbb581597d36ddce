"""Measurements beside the suites, and what made the stored data: scripts that nothing installed imports."""
