"""Meshes that cannot be written as a formula, with the scripts that made them and their licences."""
