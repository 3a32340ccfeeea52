"""Benchmark: memory of each training process, and time spent waiting for batches.

    python benchmarks/training_memory.py --data data/small --frames 684000 --steps 200 \
        --learner tests/outside/pixels.py:PixelLearner --options '{"pixels": 128}' --loaders 1

Repeats the recordings of a small data folder under other names until there are enough frames,
trains for some steps, and prints one line per process. Each recording is converted once for all its
copies; this does not affect the measured parts: packing, memory-mapping and reading.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from pydantic import TypeAdapter

from plant_bench.training import column_store as packs
from plant_bench.training import encodings, frame_store
from plant_bench.training.events import StepEnded
from plant_bench.training.learners import learner_class
from plant_bench.training.settings import TrainingSettings
from plant_bench.training.training_run import Listeners, Machine, TrainingRun, run_training

SKIPPED = 10  # first steps, which are not timed: processes start
EVERY = 1.0  # s between two samples of the memory
KINDS = ("Rss", "Pss", "Anonymous")
TARGETS = "expert-action"  # uses all frames
MEGA = 1024.0  # kB


def main() -> None:
    """Prepare the data, then train and measure in a separate process."""
    arguments = parse_arguments()
    if arguments.measure:
        measure(arguments)
        return
    with tempfile.TemporaryDirectory(dir=arguments.scratch) as place:
        begin = time.perf_counter()
        count = repeat(arguments.data, Path(place) / "data", arguments)
        print(f"{count:,} frames made in {time.perf_counter() - begin:.0f} s", flush=True)
        words = [*sys.argv[1:], "--measure", "--scratch", place]
        subprocess.run([sys.executable, __file__, *words], check=True)


def parse_arguments() -> argparse.Namespace:
    """Parse the command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--data", type=Path, required=True, help="a small data folder")
    parser.add_argument("--frames", type=int, default=684_000, help="number of frames, at least")
    parser.add_argument("--steps", type=int, default=200, help="number of training steps")
    parser.add_argument("--batch", type=int, default=128)
    parser.add_argument("--learner", default="plant")
    parser.add_argument("--options", type=json.loads, default={}, help="learner options, as JSON")
    parser.add_argument("--loaders", type=int, default=1)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--scratch", help="parent folder of the repeated data")
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    return parser.parse_args()


def repeat(small: Path, large: Path, arguments: argparse.Namespace) -> int:
    """Repeat a folder's recordings, convert them to frames, and encode them if they are cached."""
    (large / "episodes").mkdir(parents=True)
    for name in ("routes", "towns"):
        if (small / name).is_dir():
            (large / name).symlink_to((small / name).resolve())
    originals = sorted((small / "episodes").glob("*.parquet"))
    once = len(frame_store.load_frames([small], targets=TARGETS))
    for copy in range(-(-arguments.frames // once)):
        for path in originals:
            os.link(path, large / "episodes" / f"{path.stem}~{copy}.parquet")
    build_once()
    frames = frame_store.load_frames([large], targets=TARGETS)
    learner = training_run(large, arguments).learner_spec
    if learner.build().cached:
        encodings.load_encodings(frames, learner)
    return len(frames)


def build_once() -> None:
    """Build a part only once per original; the parts of its copies are hard links to it."""
    make, known = packs._build_part, {}

    def made(task, report) -> None:
        original = task.path.parts[-4], task.path.stem.partition("~")[0]
        if original in known:
            os.link(known[original], task.path)
            return
        make(task, report)
        known[original] = task.path

    packs._build_part = made


def training_run(data: Path, arguments: argparse.Namespace) -> TrainingRun:
    """Return the training to run."""
    kind = learner_class(arguments.learner)
    options = TypeAdapter(kind.Options).validate_python(arguments.options)
    out = data.parent / "model"
    return TrainingRun(
        arguments.learner,
        options,
        (data,),
        out,
        TrainingSettings(batch=arguments.batch, epochs=1, targets=TARGETS),
        machine=Machine("cpu", 1, arguments.threads, 1, arguments.loaders),
        work=out / "work",
    )


def measure(arguments: argparse.Namespace) -> None:
    """Train some steps in this process, and print memory and speed."""
    most: dict[int, dict[str, float]] = {}
    over = threading.Event()
    watcher = threading.Thread(target=watch, args=(most, over))
    steps: list[tuple[float, float]] = []

    def listen(event) -> None:
        if isinstance(event, StepEnded):
            steps.append((time.perf_counter(), event.waited))
            if len(steps) == arguments.steps:
                signal.raise_signal(signal.SIGINT)

    begin = time.perf_counter()
    watcher.start()
    run_training(
        training_run(Path(arguments.scratch) / "data", arguments), Listeners(on_event=listen)
    )
    over.set()
    watcher.join()
    print(f"first step after {steps[0][0] - begin:.0f} s")
    for pid, sizes in sorted(most.items()):
        name = "training" if pid == os.getpid() else "other"
        text = ", ".join(f"{kind} {sizes[kind] / MEGA:,.0f} MB" for kind in KINDS)
        print(f"{name:9} {text} at most")
    rest = steps[SKIPPED:]
    spent = rest[-1][0] - steps[SKIPPED - 1][0]
    waited = sum(wait for _, wait in rest)
    pace = len(rest) * arguments.batch / spent
    print(
        f"{len(rest)} steps of {arguments.batch} in {spent:.1f} s: {pace:,.0f} samples/s, "
        f"{100.0 * waited / spent:.0f} % of the time waiting for batches"
    )


def watch(most: dict[int, dict[str, float]], over: threading.Event) -> None:
    """Record the peak memory of this process and of all its descendants."""
    while not over.wait(EVERY):
        for pid in family(os.getpid()):
            sizes = most.setdefault(pid, dict.fromkeys(KINDS, 0.0))
            for kind, value in rollup(pid).items():
                sizes[kind] = max(sizes[kind], value)


def family(pid: int) -> list[int]:
    """Return the ids of a process and its descendants."""
    found = [pid]
    for path in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            found += [other for child in path.read_text().split() for other in family(int(child))]
        except OSError:
            continue
    return found


def rollup(pid: int) -> dict[str, float]:
    """Return a process's memory by kind, from the kernel, kB."""
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:  # the process has ended
        return {}
    words = [line.split() for line in lines]
    return {word[0].rstrip(":"): float(word[1]) for word in words if word[0].rstrip(":") in KINDS}


if __name__ == "__main__":
    main()
