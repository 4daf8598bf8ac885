"""Teaching grasps in simulation: candidates are tried on a bench with the hand alone, judged, and written down."""
