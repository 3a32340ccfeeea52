"""Worker processes that run tasks in parallel, and planners isolated in their own processes."""
