"""Model-based tracking: visible edges, normal flow, affine fit, gradient fit."""
