"""The leaderboard: compares runs in tables with significance tests, as files and an HTML page."""
