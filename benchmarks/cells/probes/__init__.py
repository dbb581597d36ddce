"""Cells without a walk: fidelity, motion, tessellation, numerics, signals."""
