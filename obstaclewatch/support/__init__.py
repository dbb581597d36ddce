"""What every room shares: array types, checked arguments, the store of compiled functions, quantiles."""
