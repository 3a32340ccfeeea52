"""One episode: the job, the loop, its timing."""
