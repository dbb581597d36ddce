"""Meshes as files hold them, made fit to be read: cleaned, facets of one plane found, planes that rounding spoilt."""
