"""Pose from points: POSIT, Lowe, the fully projective refinement."""
