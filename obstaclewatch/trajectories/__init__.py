"""Trajectory hypotheses: prior, likelihood and posterior over straight paths past the phone."""
