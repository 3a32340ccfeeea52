"""Why a run's episodes went wrong: look at them again, and draw what was found."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from plant_bench.data.recording import Recording
from plant_bench.errors import InputError
from plant_bench.reports.episode_selection import episodes_of
from plant_bench.reports.why.incident_figure import save_picture
from plant_bench.reports.why.incident_findings import Finding, find
from plant_bench.reports.why.incident_list import worst_first
from plant_bench.reports.why.incident_text import (
    again_line,
    episode_line,
    incident_line,
    surroundings,
)
from plant_bench.reports.why.incidents import check_recorded, incidents
from plant_bench.reports.why.verdicts import verdict
from plant_bench.runner.review.postmortem import review_episode
from plant_bench.runner.review.review_frames import Postmortem
from plant_bench.runner.run.folder import RunFolder
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import Route, load_suite

OnShare = Callable[[EpisodeResult, float], None]


@dataclass(frozen=True)
class Explanation:
    """What went wrong in one episode, infraction by infraction; `print` it to read it.

    Attributes:
        name: Of the episode's files.
        result: Its record.
        findings: One for each infraction: the seconds before it, and what the expert would do.
        postmortem: What was seen when it was simulated again; None without an infraction.
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
        """Draw each infraction and its last seconds; return where.

        Args:
            out: A folder, or a PNG file.
            tagged: Put the episode's name into those of PNG files: others go to the same place.

        Raises:
            OSError: They cannot be written.
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
    """Explain a route's episodes, one after the other.

    Args:
        folder: The run.
        route: Id or number of the route.
        repetition: The only one that is wanted; None for all.
        before: Seconds to look at before each infraction.
        on_share: Told the share of an episode that has been looked at, now and then.

    Raises:
        InputError: There is no such episode, or no recording of it.
        SimulationError: SUMO fails.
    """
    for name, result in episodes_of(folder, route, repetition):
        if not result.infractions:
            yield Explanation(name, result)
            continue
        recording = _recording(folder, name)
        check_recorded(result, len(recording))
        found = incidents(result, before)
        postmortem = review_episode(
            recording,
            result,
            _route_of(folder, result),
            [item.window for item in found],
            None if on_share is None else lambda share, of=result: on_share(of, share),
        )
        if on_share is not None:
            on_share(result, 1.0)
        yield Explanation(name, result, [find(item, postmortem) for item in found], postmortem)


def worst_route(results: Sequence[EpisodeResult]) -> str | None:
    """Return the route with the lowest score, of those with an infraction; None without any."""
    return next((item.route for item in worst_first(results) if item.infractions), None)


def picture_paths(out: Path, name: str, findings: Sequence[Finding], *, tagged: bool) -> list[Path]:
    """Return where each picture goes."""
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
            f"{folder.path} has no recording of {name}: nothing can be seen of it. Score the run "
            "again, with --recordings."
        )
        raise InputError(message)
    return Recording.load(path)


def _route_of(folder: RunFolder, result: EpisodeResult) -> Route:
    told = folder.provenance()
    suite = "" if told is None else told.suite
    found = [route for route in load_suite(suite) if route.id == result.route]
    if not found:
        message = f"The suite {suite} has no route {result.route} any more."
        raise InputError(message)
    return found[0]
