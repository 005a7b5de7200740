"""What the fusion does with bags: read a recording, replay it into a new bag."""
