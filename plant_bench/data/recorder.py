"""What is kept of an episode while it drives; arrow, which writes it, is loaded at its end."""

from collections.abc import Mapping
from pathlib import Path

from plant_bench.agent import Reason
from plant_bench.data.tick_log import Action, Ticks
from plant_bench.world.scene import Actors, Scene


class Recorder:
    """Collects the ticks of one episode and writes them on `close`; mutable.

    A tick costs next to nothing, since scenes are immutable: they are kept as they are until then.

    Args:
        path: Where to write, for instance `episode.parquet`.
        metadata: What is known of the episode before it starts, as JSON-able values.
        every: Keep actors and lights at every so many ticks alone; more than 1 thins the recording.
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
        """Keep a scene, what the agent answered to it and why; None where it was not asked.

        Args:
            scene: To keep.
            action: What the agent answered.
            reason: Why.
            disturbed: Something else than the answer was executed; thinned recordings keep it.
        """
        ticks = self._ticks
        if ticks.every > 1 and scene.tick % ticks.every:
            scene = Scene(scene.tick, scene.ego, Actors.none(), scene.lights[:0])
        ticks.scenes.append(scene)
        ticks.actions.append(action)
        ticks.reasons.append(reason)
        ticks.disturbed.append(disturbed)

    def close(self, **outcome: object) -> None:
        """Write the file, whole or not at all.

        Args:
            outcome: More metadata, known only at the end: why the agent crashed.
        """
        from plant_bench.data.recording_writer import write_recording

        write_recording(self._path, self._ticks, self._metadata | outcome)
