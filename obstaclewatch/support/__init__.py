"""What every room shares: array types, tables of columns, whole files, checked arguments, stored compiled functions."""
