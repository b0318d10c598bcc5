"""Tools of every room that know nothing of jaws: errors, files and their guarded reading, fields, progress, seeds."""
