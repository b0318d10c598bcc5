"""Products of an entry's episodes: films, data sets, and replays of its averaged targets."""
