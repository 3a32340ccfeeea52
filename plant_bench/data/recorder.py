"""Records the ticks of a running episode; Arrow is loaded only when the file is written."""

from collections.abc import Mapping
from pathlib import Path

from plant_bench.agent import Reason
from plant_bench.data.tick_log import Action, Ticks
from plant_bench.world.scene import Actors, Scene


class Recorder:
    """Collects the ticks of one episode and writes them on `close`; mutable.

    A tick costs almost nothing, since scenes are immutable and are only referenced until then.

    Args:
        path: Path of the file, for instance `episode.parquet`.
        metadata: Metadata known before the episode starts, as JSON values.
        every: Ticks between rows with actors and lights; more than 1 thins the recording.
    """

    def __init__(self, path: Path, metadata: Mapping[str, object], *, every: int = 1) -> None:
        self._path = path
        self._metadata = dict(metadata)
        self._ticks = Ticks(every)

    def add(
        self,
        scene: Scene,
        action: Action = None,
        reason: Reason | None = None,
        *,
        disturbed: bool = False,
    ) -> None:
        """Add a scene, the agent's action and its reason; None if it made no decision.

        Args:
            scene: The scene.
            action: The agent's action.
            reason: The agent's reason.
            disturbed: Whether another action was executed; stored in thinned recordings only.
        """
        ticks = self._ticks
        if ticks.every > 1 and scene.tick % ticks.every:
            scene = Scene(scene.tick, scene.ego, Actors.none(), scene.lights[:0])
        ticks.scenes.append(scene)
        ticks.actions.append(action)
        ticks.reasons.append(reason)
        ticks.disturbed.append(disturbed)

    def close(self, **outcome: object) -> None:
        """Write the file atomically.

        Args:
            outcome: Further metadata, known only at the end, e.g. why the planner crashed.
        """
        from plant_bench.data.recording_writer import write_recording

        write_recording(self._path, self._ticks, self._metadata | outcome)
