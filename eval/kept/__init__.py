"""The engine: entries under settings are cells, played in parts, kept on disk under a digest of their causes."""
