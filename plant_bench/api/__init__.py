"""What `import plant_bench` gives: what commands do, as functions that return values."""
