"""Entry point of the `plant-bench` command and of `python -m plant_bench`.

It imports nothing at module level, because every worker process loads the main module again.
"""


def main() -> None:
    """Run the command line."""
    from plant_bench.cli import main as command_line

    command_line()


if __name__ == "__main__":
    main()
