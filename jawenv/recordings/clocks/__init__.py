"""Two clocks of one recording: how late its forces are."""
