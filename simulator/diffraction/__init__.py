"""Diffraction at sharp edges: one, or several of one panel."""
