"""Image sequences of a moving object, rendered with the truth of every frame: for tests and benchmarks of trackers."""
