"""Plain text for terminals and for the comments of files."""
