"""Meshes read as reflectors: patches, smooth surfaces, wedges, creases, facets."""
