"""Skin colour: chromaticity, locus, density, regions."""
