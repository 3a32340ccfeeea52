"""Which episodes of a leaderboard have a replay, and what it is called."""

from plant_bench.reports.leaderboard.board import Leaderboard
from plant_bench.reports.replay.replay_source import AskExpert, ReplaySource


def replay_sources(
    leaderboard: Leaderboard, ask_expert: AskExpert | None = None
) -> list[ReplaySource]:
    """Return a source for each episode that was recorded; its id is "<line>/<episode>".

    Args:
        leaderboard: Whose episodes.
        ask_expert: Tells whom the expert would brake for; None leaves that out.
    """
    return [
        ReplaySource(
            id=f"{entry.line.id}/{episode.name}",
            title=entry.line.planner,
            agent=entry.run.provenance.agent,
            recording=episode.recording,
            result=episode.result,
            ask_expert=ask_expert,
        )
        for board in leaderboard.boards
        for entry in board.entries
        for episode in entry.run.episodes
        if episode.recording is not None
    ]
