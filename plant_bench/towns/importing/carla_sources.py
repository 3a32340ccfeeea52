"""CARLA's ids and towns of a suite's routes, as `import-routes` writes them into its files."""

from pathlib import Path

from plant_bench.untrusted_files import read_json

SOURCES = "carla_routes"  # key of a suite's file


def carla_routes(suite: str) -> dict[str, tuple[str, str]]:
    """Return CARLA's id and town of each route of a suite; empty for other suites.

    Args:
        suite: Folder or file of the suite, or its name.
    """
    path = Path(suite)
    files = sorted(path.glob("*.json")) if path.is_dir() else [path] if path.is_file() else []
    found: dict[str, tuple[str, str]] = {}
    for file in files:
        try:
            payload = read_json(file)
            sources = payload.get(SOURCES, {}) if isinstance(payload, dict) else {}
            found |= {str(name): (str(item[0]), str(item[1])) for name, item in sources.items()}
        except (OSError, ValueError, LookupError, TypeError, AttributeError):
            continue  # `load_suite` says what is wrong with it
    return found
