"""Files of jaw trackers: read, registered by dental landmarks, joined with a force file, and written."""
