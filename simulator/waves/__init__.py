"""What holds for every wave: the frequency band and the spreading of ray tubes."""
