"""Explains the infractions of a run: simulates its episodes again and draws each incident."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from plant_bench.data.recording import Recording
from plant_bench.errors import InputError
from plant_bench.reports.episode_selection import episodes_of
from plant_bench.reports.why.incident_figure import save_picture
from plant_bench.reports.why.incident_findings import OUT_OF_TIME, Finding, find
from plant_bench.reports.why.incident_list import worst_first
from plant_bench.reports.why.incident_text import (
    again_line,
    episode_line,
    incident_line,
    surroundings,
)
from plant_bench.reports.why.incidents import check_recorded, incidents
from plant_bench.reports.why.time_use import time_use_of
from plant_bench.reports.why.verdicts import verdict
from plant_bench.runner.review.postmortem import review_episode
from plant_bench.runner.review.resimulation import Tick, simulate_again
from plant_bench.runner.review.review_frames import Postmortem
from plant_bench.runner.run.folder import RunFolder
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import Route, load_suite

OnShare = Callable[[EpisodeResult, float], None]


@dataclass(frozen=True)
class Explanation:
    """Explanation of each infraction of one episode; `print` shows it as text.

    Attributes:
        name: Name of the episode's files.
        result: Record of the episode.
        findings: One for each infraction: what preceded it, and what the expert would do.
        postmortem: Data from simulating the episode again; None without an infraction.
    """

    name: str
    result: EpisodeResult
    findings: Sequence[Finding] = ()
    postmortem: Postmortem | None = None

    def __str__(self) -> str:
        lines = [episode_line(self.result)]
        if self.postmortem is not None:
            lines.append(again_line(self.postmortem))
            for finding in self.findings:
                lines += ["", incident_line(finding, self.result)]
                lines += [surroundings(finding, self.postmortem), verdict(finding, self.postmortem)]
        return "\n".join(lines)

    def save_pictures(self, out: Path | str, *, tagged: bool = False) -> list[Path]:
        """Draw each infraction and the seconds before it; return the paths of the pictures.

        Args:
            out: A folder, or a PNG file.
            tagged: Whether to add the episode's name to the name of the PNG file, because other
                episodes use the same one.

        Raises:
            OSError: A picture cannot be written.
        """
        if self.postmortem is None:
            return []
        paths = picture_paths(Path(out), self.name, self.findings, tagged=tagged)
        for finding, path in zip(self.findings, paths, strict=True):
            save_picture(finding, self.postmortem, path)
        return paths


def explain(
    folder: RunFolder,
    route: str,
    repetition: int | None,
    before: float,
    on_share: OnShare | None = None,
) -> Iterator[Explanation]:
    """Yield an explanation for each episode on a route.

    Args:
        folder: The run.
        route: Id or number of the route.
        repetition: Repetition of the route; None for all.
        before: Time to analyse before each infraction, seconds.
        on_share: Called repeatedly with the fraction of an episode that has been analysed.

    Raises:
        InputError: The episode or its recording does not exist.
        SimulationError: SUMO fails.
    """
    for name, result in episodes_of(folder, route, repetition):
        if not result.infractions:
            yield Explanation(name, result)
            continue
        recording = _recording(folder, name)
        check_recorded(result, len(recording))
        to_review, route_driven = incidents(result, before), _route_of(folder, result)
        postmortem = review_episode(
            recording,
            result,
            route_driven,
            [item.window for item in to_review],
            None if on_share is None else lambda share, of=result: on_share(of, share),
        )
        if on_share is not None:
            on_share(result, 1.0)
        late = any(item.kind in OUT_OF_TIME for item in result.infractions)
        use = time_use_of(recording, result.seed, route_driven) if late else None
        found = [find(item, postmortem, use) for item in to_review]
        yield Explanation(name, result, found, postmortem)


def worst_route(results: Sequence[EpisodeResult]) -> str | None:
    """Return the route with the lowest score that has an infraction; None if there is none."""
    return next((item.route for item in worst_first(results) if item.infractions), None)


def picture_paths(out: Path, name: str, findings: Sequence[Finding], *, tagged: bool) -> list[Path]:
    """Return the path of each infraction's picture."""
    if out.suffix.lower() != ".png":
        return [
            out / f"{name}_{item.incident.number}_{item.incident.infraction.kind.value}.png"
            for item in findings
        ]
    if len(findings) == 1 and not tagged:
        return [out]
    tag = f"_{name}" if tagged else ""
    return [out.with_name(f"{out.stem}{tag}_{item.incident.number}.png") for item in findings]


def _recording(folder: RunFolder, name: str) -> Recording:
    path = folder.recording_path(name)
    if not path.is_file():
        message = (
            f"{folder.path} has no recording of {name}. Score the run again with --recordings and "
            "--overwrite."
        )
        raise InputError(message)
    return Recording.load(path)


def _route_of(folder: RunFolder, result: EpisodeResult) -> Route:
    provenance = folder.provenance()
    suite = "" if provenance is None else provenance.suite
    routes = [route for route in load_suite(suite) if route.id == result.route]
    if not routes:
        message = f"The suite {suite} no longer has a route {result.route}."
        raise InputError(message)
    return routes[0]


def simulate_recorded(run: Path, route: str, repetition: int | None) -> Iterator[Tick]:
    """Simulate a recorded episode again, tick by tick.

    Args:
        run: Folder of the run.
        route: A route's id or number.
        repetition: The repetition; None for the first.

    Raises:
        InputError: There is no such episode, it has no recording, or its route has changed.
        SimulationError: SUMO fails.
    """
    folder = RunFolder.open(run)
    name, result = episodes_of(folder, route, repetition)[0]
    yield from simulate_again(_recording(folder, name), result, _route_of(folder, result))
