"""Presentation of results: terminal tables, leaderboard, replays, explanations, cards."""
