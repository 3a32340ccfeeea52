"""The leaderboard: many runs in one table, their differences tested, as files and a page."""
