"""Which of a body's facets the images of speaker and microphones see."""
