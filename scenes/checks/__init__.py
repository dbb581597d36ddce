"""Whether a scene is fit to be simulated, and what the generated ones are like."""
