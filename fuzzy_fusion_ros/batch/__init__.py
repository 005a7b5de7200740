"""The same method over whole recordings: arrays in, arrays out, compiled where numba is there."""
