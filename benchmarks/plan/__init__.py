"""From a suite file to the list of its cells."""
