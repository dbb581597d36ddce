"""Scenes to look at: pictures and a page."""
