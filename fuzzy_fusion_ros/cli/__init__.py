"""The executables: each file parses its arguments, calls one function, returns the status."""
