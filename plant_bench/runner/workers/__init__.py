"""Worker processes, and planners in processes of their own."""
