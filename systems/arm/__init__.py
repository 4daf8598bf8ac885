"""Twists of the hand to joint commands within the arm's limits."""
