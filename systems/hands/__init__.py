"""Kalman tracks of the face and two hands."""
