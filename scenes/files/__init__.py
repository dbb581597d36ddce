"""Scene files: their schema, and what becomes of them."""
