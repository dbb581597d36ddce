"""Recordings from anywhere: files, live sound, alignment, health, calibration."""
