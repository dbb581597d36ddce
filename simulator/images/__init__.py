"""The image method: planar mirrors, before and after whatever else a path meets."""
