"""Trajectory hypotheses: prior, likelihood and posterior over straight ways past the phone."""
