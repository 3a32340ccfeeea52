"""The `plant-bench` command, also as `python -m plant_bench`.

Each process that a command starts loads the module that the command began with: this one, which
loads next to nothing by itself.
"""

from plant_bench.garbage import collect_rarely


def main() -> None:
    """Run the command line."""
    collect_rarely()
    from plant_bench.cli import main as command_line

    command_line()


if __name__ == "__main__":
    main()
