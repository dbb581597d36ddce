"""From numbers to pictures: the only rooms that draw."""
