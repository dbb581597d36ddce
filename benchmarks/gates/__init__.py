"""What must hold of a run: claims about its rates and medians, no regression against a baseline, and the physics.

Each gate ends passed, failed or unmeasured; one that measured nothing is never green.
"""
