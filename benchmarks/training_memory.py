"""Benchmark: memory of each training process, and time spent waiting for batches.

    python benchmarks/training_memory.py --data data/small --frames 684000 --steps 200 \
        --learner tests/outside/pixels.py:PixelLearner --options '{"pixels": 128}' --loaders 1

Repeats the recordings of a small folder under other names until there are so many frames, learns
from them for some steps, and prints a line a process. What is made of a recording is made once for
all its copies; what is measured, packing, mapping and reading, knows nothing of that.
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

SKIPPED = 10  # steps, in which processes start
EVERY = 1.0  # s between two looks at the memory
KINDS = ("Rss", "Pss", "Anonymous")
TARGETS = "expert-action"  # no frame is left out
MEGA = 1024.0  # kB


def main() -> None:
    """Prepare the data, train in a process of its own, and print."""
    asked = arguments()
    if asked.measure:
        measure(asked)
        return
    with tempfile.TemporaryDirectory(dir=asked.scratch) as place:
        begin = time.perf_counter()
        count = repeat(asked.data, Path(place) / "data", asked)
        print(f"{count:,} frames made in {time.perf_counter() - begin:.0f} s", flush=True)
        words = [*sys.argv[1:], "--measure", "--scratch", place]
        subprocess.run([sys.executable, __file__, *words], check=True)


def arguments() -> argparse.Namespace:
    """Return what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--data", type=Path, required=True, help="a small folder of data")
    parser.add_argument("--frames", type=int, default=684_000, help="how many to have")
    parser.add_argument("--steps", type=int, default=200, help="how many to train")
    parser.add_argument("--batch", type=int, default=128)
    parser.add_argument("--learner", default="plant")
    parser.add_argument("--options", type=json.loads, default={}, help="of the learner, as JSON")
    parser.add_argument("--loaders", type=int, default=1)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--scratch", help="where the repeated data goes")
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    return parser.parse_args()


def repeat(small: Path, large: Path, asked: argparse.Namespace) -> int:
    """Repeat a folder's recordings, make frames of them, and encode them if they are cached."""
    (large / "episodes").mkdir(parents=True)
    for name in ("routes", "towns"):
        if (small / name).is_dir():
            (large / name).symlink_to((small / name).resolve())
    originals = sorted((small / "episodes").glob("*.parquet"))
    once = len(frame_store.load_frames([small], targets=TARGETS))
    for copy in range(-(-asked.frames // once)):
        for path in originals:
            os.link(path, large / "episodes" / f"{path.stem}~{copy}.parquet")
    make_once()
    frames = frame_store.load_frames([large], targets=TARGETS)
    learner = training_run(large, asked).learner_spec
    if learner.build().cached:
        encodings.load_encodings(frames, learner)
    return len(frames)


def make_once() -> None:
    """Make a part once for each original; the parts of its copies are links to it."""
    make, known = packs._make_part, {}

    def made(task, report) -> None:
        original = task.path.parts[-4], task.path.stem.partition("~")[0]
        if original in known:
            os.link(known[original], task.path)
            return
        make(task, report)
        known[original] = task.path

    packs._make_part = made


def training_run(data: Path, asked: argparse.Namespace) -> TrainingRun:
    """Return the training."""
    kind = learner_class(asked.learner)
    options = TypeAdapter(kind.Options).validate_python(asked.options)
    out = data.parent / "model"
    return TrainingRun(
        asked.learner,
        options,
        (data,),
        out,
        TrainingSettings(batch=asked.batch, epochs=1, targets=TARGETS),
        machine=Machine("cpu", 1, asked.threads, 1, asked.loaders),
        work=out / "work",
    )


def measure(asked: argparse.Namespace) -> None:
    """Train some steps in this process, and print what was seen."""
    most: dict[int, dict[str, float]] = {}
    over = threading.Event()
    watcher = threading.Thread(target=watch, args=(most, over))
    steps: list[tuple[float, float]] = []

    def listen(event) -> None:
        if isinstance(event, StepEnded):
            steps.append((time.perf_counter(), event.waited))
            if len(steps) == asked.steps:
                signal.raise_signal(signal.SIGINT)

    begin = time.perf_counter()
    watcher.start()
    run_training(training_run(Path(asked.scratch) / "data", asked), Listeners(on_event=listen))
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
    pace = len(rest) * asked.batch / spent
    print(
        f"{len(rest)} steps of {asked.batch} in {spent:.1f} s: {pace:,.0f} samples/s, "
        f"{100.0 * waited / spent:.0f} % of the time waiting for batches"
    )


def watch(most: dict[int, dict[str, float]], over: threading.Event) -> None:
    """Note the greatest size of this process and of all that it started."""
    while not over.wait(EVERY):
        for pid in family(os.getpid()):
            sizes = most.setdefault(pid, dict.fromkeys(KINDS, 0.0))
            for kind, value in rollup(pid).items():
                sizes[kind] = max(sizes[kind], value)


def family(pid: int) -> list[int]:
    """Return a process and all below it."""
    found = [pid]
    for path in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            found += [other for child in path.read_text().split() for other in family(int(child))]
        except OSError:
            continue
    return found


def rollup(pid: int) -> dict[str, float]:
    """Return what the kernel says of a process's memory, kB."""
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:  # it has ended
        return {}
    words = [line.split() for line in lines]
    return {word[0].rstrip(":"): float(word[1]) for word in words if word[0].rstrip(":") in KINDS}


if __name__ == "__main__":
    main()
