"""MCAP files: an index, a scan that salvages damaged files, and a writer."""
