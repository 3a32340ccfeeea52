"""Loads the replay data of one episode, and encodes it as a script for the replay page."""

from dataclasses import dataclass

import numpy as np

from plant_bench.agent import NO_ACTOR, PLAN_STEPS, Cause
from plant_bench.reports.replay.attention import Attention, attention_of
from plant_bench.reports.replay.column_compression import CENTI, MILLI, pack, quantised
from plant_bench.reports.replay.overlay import (
    NO_CAUSE,
    Plans,
    Reasons,
    expert_view_of,
    hazard_facts,
    infraction_facts,
    limit_steps,
    plans_of,
    progress_of,
    reasons_of,
    result_facts,
    stop_line,
)
from plant_bench.reports.replay.replay_frames import FRAME, FRAME_TICKS, Frames, frames_of
from plant_bench.reports.replay.replay_source import (
    ReplaySource,
    load_recording,
    load_route,
    load_town_of,
)
from plant_bench.runner.review.expert_braking import EXPERT, ExpertView
from plant_bench.text_escaping import script_json
from plant_bench.world.route import Route
from plant_bench.world.scene import EGO_EXTENT, TICK, ActorKind, Light
from plant_bench.world.town import Town

REPLAY_FORMAT = 1
SHARE_SCALE = 255.0  # steps of an actor's relevance


@dataclass(frozen=True, eq=False)
class EpisodeReplay:
    """All replay data of an episode.

    Attributes:
        source: The episode's files and record.
        town: The town.
        route: The route driven.
        frames: Poses of ego and actors, and states of lights.
        progress: Arc length along the route at each frame, metres.
        plans: The planner's plans.
        reasons: The planner's reasons.
        attention: The planner's attention.
        expert: The actors that the expert would brake for; None if not requested.
        infractions: The results of `infraction_facts`.
    """

    source: ReplaySource
    town: Town
    route: Route
    frames: Frames
    progress: np.ndarray
    plans: Plans
    reasons: Reasons
    attention: Attention
    expert: ExpertView | None
    infractions: tuple[dict[str, object], ...]


def load_episode(source: ReplaySource) -> EpisodeReplay:
    """Return all replay data of an episode.

    Raises:
        InputError: Its recording, route or town is missing, broken or changed.
    """
    recording = load_recording(source)
    route = load_route(source)
    town = load_town_of(source)
    progress = progress_of(recording, route)
    result = source.result
    return EpisodeReplay(
        source,
        town,
        route,
        frames_of(recording),
        progress.along[::FRAME_TICKS],
        plans_of(recording),
        reasons_of(recording),
        attention_of(result, source.agent, recording, route, progress),
        expert_view_of(source, recording, route),
        tuple(infraction_facts(item, recording) for item in result.infractions),
    )


def replay_script(episode: EpisodeReplay) -> str:
    """Return the script that passes an episode to the page."""
    packed = pack(_columns(episode))
    result, route = episode.source.result, episode.route
    facts: dict[str, object] = {
        "format": REPLAY_FORMAT,
        "id": episode.source.id,
        "title": episode.source.title,
        "protocol": result.protocol,
        "route": result.route,
        "town": result.town,
        "townChecksum": result.town_checksum,
        "scenario": result.scenario,
        "repetition": result.repetition,
        "seed": result.seed,
        "density": result.density,
        "step": FRAME,
        "tick": TICK,
        "egoExtent": EGO_EXTENT,
        "scales": {"length": CENTI, "angle": MILLI, "share": SHARE_SCALE},
        "kinds": [kind.name.lower() for kind in ActorKind],
        "lightNames": [light.name.lower() for light in Light],
        "causes": [cause.name.lower() for cause in Cause],
        "result": result_facts(result),
        "infractions": episode.infractions,
        "hazards": [hazard_facts(item, route) for item in result.hazards],
        "limits": limit_steps(route),
        "signals": [stop_line(route, item) for item in route.signal_passages],
        "attentionNote": episode.attention.note,
        "expertNote": "" if episode.expert is None else episode.expert.note,
        "expertDrove": result.agent == EXPERT,
        "columns": packed.columns,
        "data": packed.data,
    }
    return f"plantBench.addEpisode({script_json(facts)});\n"


def missing_script(source: ReplaySource, why: str) -> str:
    """Return the script that tells the page why there is no replay."""
    return f"plantBench.addEpisode({script_json({'id': source.id, 'error': why})});\n"


def _columns(episode: EpisodeReplay) -> dict[str, tuple[np.ndarray, int]]:
    """Return all columns, each with the order of differences that compresses it best."""
    return {
        **_ego_columns(episode.frames.egos),
        **_track_columns(episode.frames),
        **_plan_columns(episode.plans),
        **_reason_columns(episode.reasons),
        **_attention_columns(episode.attention),
        **_expert_columns(episode.expert),
        "progress": (quantised(episode.progress, CENTI), 2),
        "lights": (episode.frames.lights.T.reshape(-1).astype(int), 1),
        "route.x": (quantised(episode.route.points[:, 0], CENTI), 2),
        "route.y": (quantised(episode.route.points[:, 1], CENTI), 2),
    }


def _ego_columns(egos: np.ndarray) -> dict[str, tuple[np.ndarray, int]]:
    scales = {"x": CENTI, "y": CENTI, "yaw": MILLI, "speed": CENTI, "acceleration": CENTI}
    columns: dict[str, tuple[np.ndarray, int]] = {}
    for place, (name, scale) in enumerate(scales.items()):
        columns[f"ego.{name}"] = (quantised(egos[:, place], scale), 2 if place < 3 else 1)
    return columns


def _track_columns(frames: Frames) -> dict[str, tuple[np.ndarray, int]]:
    tracks = frames.tracks
    return {
        "track.id": (tracks.ids, 1),
        "track.kind": (tracks.kinds.astype(int), 0),
        "track.length": (quantised(tracks.extents[:, 0], CENTI), 0),
        "track.width": (quantised(tracks.extents[:, 1], CENTI), 0),
        "track.first": (tracks.first, 0),
        "track.count": (np.diff(tracks.starts), 0),
        "pose.x": (quantised(tracks.poses[:, 0], CENTI), 2),
        "pose.y": (quantised(tracks.poses[:, 1], CENTI), 2),
        "pose.yaw": (quantised(tracks.poses[:, 2], MILLI), 2),
    }


def _plan_columns(plans: Plans) -> dict[str, tuple[np.ndarray, int]]:
    waypoints = quantised(plans.waypoints.reshape(-1, 2 * PLAN_STEPS), CENTI)
    columns = {"plan.tick": (plans.ticks, 2)}
    for place in range(waypoints.shape[1]):
        columns[f"plan.{place}"] = (waypoints[:, place], 1)
    return columns


def _reason_columns(reasons: Reasons) -> dict[str, tuple[np.ndarray, int]]:
    if (reasons.causes == NO_CAUSE).all():
        return {}
    return {
        "reason.cause": (reasons.causes - NO_CAUSE, 1),  # 0 if not known
        "reason.actor": (reasons.actors - NO_ACTOR, 1),
    }


def _attention_columns(attention: Attention) -> dict[str, tuple[np.ndarray, int]]:
    return {
        "attention.tick": (attention.ticks, 2),
        "attention.count": (np.diff(attention.starts), 0),
        "attention.actor": (attention.actors, 1),
        "attention.share": (quantised(attention.shares, SHARE_SCALE), 0),
    }


def _expert_columns(expert: ExpertView | None) -> dict[str, tuple[np.ndarray, int]]:
    if expert is None:
        return {}
    return {"expert.tick": (expert.ticks, 2), "expert.actor": (expert.actors - NO_ACTOR, 1)}
