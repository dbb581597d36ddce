"""What every room shares: array types, checked arguments, and the store of compiled functions."""
