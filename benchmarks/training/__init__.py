"""What `TrackingDetector` learns from simulated walks: `python -m benchmarks.training --help`."""
