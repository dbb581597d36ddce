"""The streets of the paper: surroundings, and approaches placed in them."""
