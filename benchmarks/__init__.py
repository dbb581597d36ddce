"""Suites, runs, scores, figures and the command line: detectors on simulated recordings against ground truth."""
