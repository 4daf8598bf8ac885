"""Writes the meshes, prints and object models of this folder: ``python -m vipr.models.build``. A test compares them with what is kept."""
