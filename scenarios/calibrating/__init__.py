"""Calibrating a camera: views of a board, simulated or recorded, and the estimate made of them."""
