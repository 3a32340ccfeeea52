"""`python -m plant_bench` is `plant-bench`."""

from plant_bench.cli import main

if __name__ == "__main__":
    main()
