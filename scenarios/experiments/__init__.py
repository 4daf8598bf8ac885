"""Experiments of the paper, repeated: made writers and people, filmed, tracked and recognised."""
