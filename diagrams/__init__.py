"""Stages wired to robots: one Diagram subclass a file, no algorithm here."""
