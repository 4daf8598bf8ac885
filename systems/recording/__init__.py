"""What a run leaves behind: MCAP log, video, report."""
