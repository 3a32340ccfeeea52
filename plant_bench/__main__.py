"""The `plant-bench` command, also as `python -m plant_bench`.

Each process that a command starts loads the module that the command began with: this one, which
loads nothing by itself.
"""


def main() -> None:
    """Run the command line."""
    from plant_bench.cli import main as command_line

    command_line()


if __name__ == "__main__":
    main()
