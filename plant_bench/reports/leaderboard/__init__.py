"""The leaderboard: many runs in one table, with tests of their differences, as files and as a page."""
