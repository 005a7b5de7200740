"""The executables: each file parses the arguments, calls one function and returns the status."""
