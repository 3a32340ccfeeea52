"""Reports of a map import: rows for the terminal, Markdown and JSON."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict

from plant_bench.towns.importing.map_findings import Finding
from plant_bench.towns.town_summary import summarise
from plant_bench.world.route import Route
from plant_bench.world.town import Town

ROUTE_HEADS = ("route", "length", "hazards")
HEADS = ("problem", "outcome", "count", "lanes removed", "details", "examples")
_LONGEST = 60  # characters of an example


def finding_rows(findings: Sequence[Finding], examples: int = 2) -> list[list[object]]:
    """Return one row per finding, with the columns of `HEADS`."""
    return [
        [
            item.what,
            item.outcome,
            item.count,
            f"{item.lane_metres / 1000.0:.2f} km" if item.lane_metres else "-",
            item.done,
            _some(item.examples[:examples]),
        ]
        for item in findings
    ]


def removed_lane_km(findings: Sequence[Finding]) -> float:
    """Return the kilometres of lanes that repairs removed."""
    return sum(item.lane_metres for item in findings) / 1000.0


def report_payload(
    town: Town, routes: Sequence[Route], findings: Sequence[Finding], offset: tuple[float, float]
) -> dict:
    """Return an import's report as JSON-able values."""
    return {
        "town": asdict(summarise(town)),
        "removed_lane_km": round(removed_lane_km(findings), 3),
        "offset": list(offset),
        "routes": [
            {"id": r.id, "length": round(r.length, 1), "hazards": len(r.hazards)} for r in routes
        ],
        "findings": [item.to_payload() for item in findings],
    }


def report_markdown(
    town: Town, routes: Sequence[Route], findings: Sequence[Finding], request: dict
) -> str:
    """Return an import's report as Markdown.

    Args:
        town: The town.
        routes: Routes through it.
        findings: Repairs and remaining problems.
        request: Settings of the import; `file` is the map file's name.
    """
    table = _table(HEADS, finding_rows(findings, 5))
    driven = _table(ROUTE_HEADS, [[r.id, f"{r.length:.0f} m", _hazards(r)] for r in routes])
    width, height = town.extent
    summary = (
        f"Made from `{request['file']}` by `plant-bench import`: {town.lane_km:.1f} km of lanes "
        f"({removed_lane_km(findings):.1f} km of the map's were removed) on "
        f"{width:.0f} x {height:.0f} m, {len(town.edges)} edges, {len(town.signals)} signals."
    )
    nothing = ["No repairs were necessary, and no problems remain."]
    found = table if findings else nothing
    return "\n".join([f"# {town.name}", "", summary, "", *found, "", *driven, ""])


def _table(heads: Sequence[str], rows: Sequence[Sequence[object]]) -> list[str]:
    lines = [heads, ("---",) * len(heads), *rows]
    return ["| " + " | ".join(str(cell).replace("|", "/") for cell in row) + " |" for row in lines]


def _hazards(route: Route) -> str:
    counts = Counter(hazard.kind for hazard in route.hazards)
    return ", ".join(f"{count} {kind}" for kind, count in sorted(counts.items())) or "none"


def _some(examples: Sequence[str]) -> str:
    short = (item if len(item) <= _LONGEST else f"{item[:_LONGEST]}..." for item in examples)
    return "; ".join(short)
