"""One episode, a suite of them over worker processes, and the folder their records live in."""
