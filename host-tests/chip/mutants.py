"""Changes a line of the drivers at a time, builds the production image, and says which changes the tests catch.

    MGPI_CHIP_PYTHON=target/chip-model/bin/python MGPI_CHIP_PROGRAM=mutants.py \
        cargo test -p host-tests --test chip

The changes are those of `mutants.csv`: a file below `firmware`, what stands there exactly once, what takes its place, the
tests that are most likely to catch it, and why none has to where none does. A copy of the project is changed, and
built. The tests that are likely to catch a change run first, then all others, up to the first that fails; those of
other images, which are not built here, are skipped.
Ends with 1 where less than 95 % are caught, where one that is not caught has no reason, or where one cannot be built.

| variable | what it does |
|---|---|
| MGPI_MUTANTS | a list of numbers, as `3,17`: these only |
| MGPI_MUTANTS_SEED | another order, by chance: a part of the run is then a fair sample of the whole. Without it in the file's |
| MGPI_MUTANTS_MINUTES | no change is begun behind so many |
| MGPI_MUTANTS_RESULTS | a file that the outcomes go to, a line each; what it has already is not tried again, but counted |
| MGPI_MUTANTS_BY | put before each build and each run of tests, as `nice` |
"""

import contextlib
import csv
import json
import os
import pathlib
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import unittest

HERE = pathlib.Path(__file__).parent
PROJECT = HERE.parents[1]
# Not below the project, whose settings of cargo would count twice.
COPY = pathlib.Path(tempfile.mkdtemp(prefix="mutants-"))
TARGET = PROJECT / "target" / "mutants"
TRIPLE = "thumbv7em-none-eabihf"
IMAGE = TARGET / TRIPLE / "firmware" / "stm32f405"
SEAL = TARGET / "seal"
BY = os.environ.get("MGPI_MUTANTS_BY", "").split()
# Without debug information, which the model does not read, and which takes longer than the code.
BUILD = [
    *BY, "cargo", "build", "--quiet", "--package", "images", "--profile", "firmware", "--bin", "stm32f405", "--bin", "starter",
    "--features", "stm32f405", "--target", TRIPLE, "--target-dir", str(TARGET), "--config", "profile.firmware.debug=false",
]
LEAST_SHARE = 0.95
# The longest that a test may take with a change: of the processor, so that a machine that has other work catches nothing, and,
# for one that waits for ever, by the clock. Unit: s.
LIMIT_CPU_S, LIMIT_S = 120, 3600
KEPT = {name: value for name, value in os.environ.items() if name not in ("CARGO_ENCODED_RUSTFLAGS", "RUSTFLAGS")}


def copy_project():
    """Copies what git knows of the project, as it is now, and the program that seals an image."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=PROJECT, check=True, capture_output=True, text=True)
    for name in listed.stdout.splitlines():
        source, place = PROJECT / name, COPY / name
        if source.is_file():
            place.parent.mkdir(parents=True, exist_ok=True)
            # As of now: what an earlier run has built of a change counts as older, and is built anew.
            shutil.copy(source, place)
    subprocess.run(["cargo", "build", "--quiet", "--bin", "xtask"], cwd=PROJECT, env=KEPT, check=True)
    TARGET.mkdir(parents=True, exist_ok=True)
    shutil.copy2(PROJECT / "target" / "debug" / "xtask", SEAL)


def build():
    """Builds the image; whether it can be built, and what is said against it."""
    done = subprocess.run(BUILD, cwd=COPY, env=KEPT, capture_output=True, text=True, check=False)
    if done.returncode == 0:
        subprocess.run([SEAL, "seal", str(IMAGE)], env=KEPT, check=True)
    return done.returncode == 0, done.stderr


def names(modules):
    """The tests: those of these modules first, then all others."""

    def of(suite):
        for test in suite:
            yield from of(test) if isinstance(test, unittest.TestSuite) else [test.id()]

    found = list(of(unittest.defaultTestLoader.discover(str(HERE))))
    return sorted(found, key=lambda name: name.split(".")[0] not in modules)


def caught_by(modules):
    """The first test that fails, and what is said of it; none where all pass."""
    errors = COPY / "serve.txt"
    server = subprocess.Popen(
        [*BY, sys.executable, "serve.py"], cwd=HERE, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors.open("w"),
        text=True, env={**os.environ, "MGPI_CHIP_IMAGE": str(IMAGE)}, start_new_session=True,
        # Each test is a process of its own, whose time begins with it.
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (LIMIT_CPU_S, LIMIT_CPU_S)),
    )
    try:
        for name in names(modules):
            # One that never ends is caught, too.
            watch = threading.Timer(LIMIT_S, lambda: os.killpg(server.pid, 9))
            watch.start()
            with contextlib.suppress(BrokenPipeError):
                print(name, file=server.stdin, flush=True)
            line = server.stdout.readline()
            watch.cancel()
            if not line:
                return name, f"the program that runs the tests has ended\n{errors.read_text(encoding='utf-8')}"
            answer = json.loads(line)
            if not answer["ok"]:
                return name, answer["said"]
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(server.pid, 9)
        server.wait()
    return None


def try_change(mutant, shown):
    """`caught by` a test, `survives`, or `cannot be built`."""
    place = COPY / "firmware" / mutant["file"]
    text = place.read_text(encoding="utf-8")
    was, becomes = (mutant[name].replace("\\n", "\n") for name in ("was", "becomes"))
    if text.count(was) != 1:
        sys.exit(f"{shown}: stands there {text.count(was)} times")
    place.write_text(text.replace(was, becomes), encoding="utf-8")
    is_built, said = build()
    place.write_text(text, encoding="utf-8")
    if not is_built:
        print(said)
        return "cannot be built"
    failed = caught_by(mutant["tests"].split())
    return f"caught by {failed[0]}" if failed else "survives"


def main():
    copy_project()
    is_built, said = build()
    if not is_built:
        sys.exit(said)
    failed = caught_by([])
    if failed:
        sys.exit("without a change {} fails: {}".format(*failed))
    chosen = os.environ.get("MGPI_MUTANTS")
    numbers = {int(number) for number in chosen.split(",")} if chosen else None
    results = pathlib.Path(os.environ.get("MGPI_MUTANTS_RESULTS", COPY / "results.csv"))
    done = {}
    if results.exists():
        with open(results, newline="", encoding="utf-8") as file:
            done = {shown: outcome for shown, outcome in csv.reader(file)}
    with open(HERE / "mutants.csv", newline="", encoding="utf-8") as file:
        mutants = list(enumerate(csv.DictReader(file), 1))
    if "MGPI_MUTANTS_SEED" in os.environ:
        random.Random(os.environ["MGPI_MUTANTS_SEED"]).shuffle(mutants)
    end = time.monotonic() + 60 * float(os.environ.get("MGPI_MUTANTS_MINUTES", "inf"))
    reasons = {}
    for number, mutant in mutants:
        if numbers is not None and number not in numbers:
            continue
        shown = f"{number:3} {mutant['file']}: `{mutant['was']}` -> `{mutant['becomes']}`"
        reasons[shown] = mutant["reason"]
        if shown in done or time.monotonic() > end:
            continue
        begin = time.monotonic()
        done[shown] = outcome = try_change(mutant, shown)
        with open(results, "a", newline="", encoding="utf-8") as file:
            csv.writer(file).writerow([shown, outcome])
        print(f"{shown}: {outcome} ({time.monotonic() - begin:.0f} s)", flush=True)
    tried = {shown: outcome for shown, outcome in done.items() if shown in reasons}
    unbuilt = [shown for shown, outcome in tried.items() if outcome == "cannot be built"]
    survived = [shown for shown, outcome in tried.items() if outcome == "survives"]
    count = len(tried) - len(unbuilt)
    caught = count - len(survived)
    print(f"{caught} of {count} changes are caught, {100 * caught / max(count, 1):.1f} %, of {len(reasons)} that there are")
    unexplained = [shown for shown in survived if not reasons[shown]]
    for shown in survived:
        print(f"survives: {shown}: {reasons[shown] or 'without a reason'}")
    for shown in unbuilt:
        print(f"not built: {shown}")
    sys.exit(bool(unexplained or unbuilt) or caught < LEAST_SHARE * count)


if __name__ == "__main__":
    try:
        main()
    finally:
        shutil.rmtree(COPY)
