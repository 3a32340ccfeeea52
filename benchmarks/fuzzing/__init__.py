"""The formats that `benchmarks/fuzz.py` tests, with valid files and their readers."""
