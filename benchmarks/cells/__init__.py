"""One cell: simulate one walk, run the detectors on the same recording, compare with ground truth, return numbers.

Everything that decides a cell's numbers lives here or in the other three packages; the fingerprint of that
source is part of a cell's name, so a cell is never mixed with those of another version.
"""
