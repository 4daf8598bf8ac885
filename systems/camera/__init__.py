"""The camera: lens model, image imperfections, recorded video."""
