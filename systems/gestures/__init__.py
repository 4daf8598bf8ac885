"""Trajectories to named gestures: segmentation, hidden Markov models, recogniser."""
