"""Servo laws: from errors in pose or image to a twist of the hand."""
