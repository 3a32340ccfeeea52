"""Lists the replays of a leaderboard: one for each recorded episode."""

from plant_bench.reports.leaderboard.board import Leaderboard
from plant_bench.reports.replay.replay_source import AskExpert, ReplaySource


def replay_sources(
    leaderboard: Leaderboard, ask_expert: AskExpert | None = None
) -> list[ReplaySource]:
    """Return a source for each episode that was recorded; its id is "<row>/<episode>".

    Args:
        leaderboard: The leaderboard.
        ask_expert: Returns the actor that the expert would brake for; None leaves that out.
    """
    return [
        ReplaySource(
            id=f"{entry.row.id}/{episode.name}",
            title=entry.row.planner,
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
