"""The decision of `TrackingDetector`, learned from simulated walks: `python -m benchmarks.training --help`."""
