"""People to be seen: random persons and their motion in the rendered living room, and clips of real ones."""
