"""The data of the leaderboard page as compact JSON: rows, differences, breakdowns, episodes."""

from collections.abc import Sequence

from plant_bench.reports.leaderboard.board import Board, Difference, Entry, Leaderboard
from plant_bench.reports.leaderboard.exports import without_nan
from plant_bench.reports.leaderboard.rows import Row
from plant_bench.reports.leaderboard.score_sources import Episode
from plant_bench.reports.leaderboard.table_text import board_title, planner_text
from plant_bench.scoring.episode_measures import Number
from plant_bench.scoring.hazard_outcomes import hazard_counts, survived
from plant_bench.scoring.infractions import COLLISIONS, Infraction, InfractionKind, Status
from plant_bench.scoring.metrics import Scores, Spread
from plant_bench.scoring.metrics_table import (
    RANKED,
    Metric,
    Shown,
    headline_metrics,
    score_metrics,
    shown_metrics,
)
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import EpisodeResult
from plant_bench.text_escaping import script_json
from plant_bench.world.hazard import HazardKind, Phase
from plant_bench.world.scene import ActorKind

KINDS, HAZARD_KINDS, STATUSES = list(InfractionKind), list(HazardKind), list(Status)
PHASES, ACTORS = list(Phase), list(ActorKind)


def page_json(leaderboard: Leaderboard, *, replays: bool) -> str:
    """Return the page's data as JSON that is safe inside a script element.

    Args:
        leaderboard: The leaderboard.
        replays: Whether episodes with a recording have a replay beside the page.
    """
    payload = {
        "scores": [_column(metric) for metric in headline_metrics()],
        "measures": [_column(metric) for metric in shown_metrics(Shown.MEASURE)],
        "ranked": RANKED,
        "kinds": [kind.value for kind in KINDS],
        "hazards": [kind.value for kind in HAZARD_KINDS],
        "statuses": [status.value for status in STATUSES],
        "phases": [phase.value for phase in PHASES],
        "actors": [actor.name.lower() for actor in ACTORS],
        "boards": [_board(board, replays) for board in leaderboard.boards],
        "notes": leaderboard.notes,
    }
    return script_json(without_nan(payload))


def _board(board: Board, replays: bool) -> dict[str, object]:
    routes = {item.result.route: item.result.town for e in board.entries for item in e.run.episodes}
    scenarios = {
        key: place
        for place, key in enumerate(
            sorted({item.result.scenario for e in board.entries for item in e.run.episodes})
        )
    }
    towns = sorted(set(routes.values()))
    route_names = sorted(routes, key=lambda route: (routes[route], _natural(route)))
    places = {route: place for place, route in enumerate(route_names)}
    ids = [row.id for row in board.rows]
    return {
        "title": board_title(board),
        "world": board.world,
        "protocol": board.protocol,
        "suite": board.suite,
        "penalties": board.penalties,
        "source": board.source,
        "towns": towns,
        "routes": [[route, towns.index(routes[route])] for route in route_names],
        "lines": [_row(board, row) for row in board.rows],
        "differences": [_difference(item, ids) for item in board.differences],
        "rankings": [
            [item.ranker, item.planner or "", *_spread(item.score.score, 6), item.score.episodes]
            for item in board.rankings
        ],
        "details": [_detail(entry) for entry in board.entries],
        "episodes": [
            [_episode(item, entry, places, scenarios, replays) for item in entry.run.episodes]
            for entry in board.entries
        ],
    }


def _column(metric: Metric) -> dict[str, object]:
    """Return what the page needs of a metric."""
    return {
        "name": metric.name,
        "label": metric.label,
        "unit": metric.unit,
        "digits": metric.digits,
        "better": metric.better,
        "about": metric.description,
        "ofEpisode": metric.episode is not None,
    }


def _row(board: Board, row: Row) -> dict[str, object]:
    return {
        "id": row.id,
        "planner": planner_text(board, row),
        "track": row.track,
        "inputs": row.inputs,
        "scores": _scores(row.scores),
        "it": row.inference_ms,
        "tokens": row.inference_tokens,
        "processor": row.processor,
        "rfds": _spread(row.rfds, 6),
        "ranker": row.ranker,
        "parameters": row.parameters,
        "date": row.date,
        "repetitions": row.repetitions,
        "episodes": row.episodes,
        "expected": row.expected,
        "complete": board.is_complete(row),
        "checksum": row.agent_checksum[:12],
        "source": row.source,
        "rates": {kind: round(rate, 5) for kind, rate in row.rates.items()},
        "km": row.km,
    }


def _difference(item: Difference, ids: Sequence[str]) -> list[object]:
    paired = item.paired
    numbers = (paired.mean, paired.low, paired.high, paired.p_value, item.p_corrected)
    return [
        ids.index(item.better),
        ids.index(item.worse),
        *(round(number, 5) for number in numbers),
        paired.pairs,
        paired.routes,
        int(item.significant),
    ]


def _detail(entry: Entry) -> dict[str, object]:
    summary = entry.summary
    collisions = [
        item
        for result in entry.run.results
        for item in result.infractions
        if item.kind in COLLISIONS
    ]
    return {
        "towns": {town: _scores(scores) for town, scores in summary.towns.items()},
        "counts": {
            kind.value: sum(item.kind is kind for r in entry.run.results for item in r.infractions)
            for kind in KINDS
        },
        "statuses": {status.value: count for status, count in summary.statuses.items()},
        "hazards": {
            kind.value: [count.placed, count.met, count.survived, count.void]
            for kind, count in hazard_counts(entry.run.results).items()
        },
        "causes": [sum(item.cause == cause for item in collisions) for cause in ("ego", "other")],
        "measures": {name: round(value, 4) for name, value in summary.measures.values.items()},
    }


def _scores(scores: Scores) -> dict[str, list[float]]:
    """Return scores by name, with so many decimals that the page rounds only once."""
    return {
        metric.name: _spread(scores[metric.name], metric.digits + 6)
        for metric in score_metrics()
        if metric.name in scores
    }


def _spread(spread: Spread, digits: int) -> list[float]:
    return [round(spread.mean, digits), round(spread.std, digits)]


def _episode(
    item: Episode,
    entry: Entry,
    routes: dict[str, int],
    scenarios: dict[str, int],
    replays: bool,
) -> list[object]:
    """Return an episode as a list; `web/src/leaderboard/payload.js` names its places."""
    result, penalties = item.result, entry.summary.penalties
    return [
        item.name,
        routes[result.route],
        result.repetition,
        scenarios[result.scenario],
        STATUSES.index(result.status),
        _episode_scores(result, penalties),
        round(result.duration, 1),
        [_infraction(infraction) for infraction in result.infractions],
        [
            [HAZARD_KINDS.index(hazard.kind), PHASES.index(hazard.phase), round(hazard.time, 1)]
            + [0] * (not survived(result, hazard))
            for hazard in result.hazards
        ],
        int(replays and item.recording is not None),
        result.reason,
    ]


def _episode_scores(result: EpisodeResult, penalties: PenaltyScheme) -> list[Number | None]:
    """Return an episode's scores, in the order of the page's `scores`.

    They are rounded to three more decimals than are shown, since pages hold many episodes.
    """
    scores = []
    for metric in headline_metrics():
        if metric.episode is not None:
            value = metric.episode(result, penalties)
            scores.append(None if value is None else round(value, metric.digits + 3))
    return scores


def _infraction(item: Infraction) -> list[object]:
    actor = -1 if item.actor_kind is None else ACTORS.index(item.actor_kind)
    values = [KINDS.index(item.kind), round(item.time, 1), actor, item.cause or "", item.share]
    return values if item.share is not None else values[:-1]


def _natural(name: str) -> tuple[int, str]:
    """Return a key that sorts town01-2 before town01-10."""
    return len(name), name
