"""Camera calibration with a board in the robot's hand: intrinsics, the camera in the world, the board in the hand."""
