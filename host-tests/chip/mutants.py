"""Changes a line of the drivers at a time, builds the production image, and says which changes the tests catch.

    MGPI_CHIP_PYTHON=target/chip-model/bin/python MGPI_CHIP_PROGRAM=mutants.py \
        cargo test -p host-tests --test chip

The changes are those of `mutants.csv`: a file below `firmware`, what stands there exactly once, what takes its place, the
tests that are most likely to catch it, and why none has to where none does. A copy of the project is changed, and
built. Ends with 1 where less than 95 % are caught, where one that is not caught has no reason, or where one cannot be built.

Set MGPI_MUTANTS to a list of numbers, as `3,17`, to try these only.
"""

import csv
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).parent
PROJECT = HERE.parents[1]
# Not below the project, whose settings of cargo would count twice.
COPY = pathlib.Path(tempfile.mkdtemp(prefix="mutants-"))
TARGET = PROJECT / "target" / "mutants"
TRIPLE = "thumbv7em-none-eabihf"
IMAGE = TARGET / TRIPLE / "firmware" / "stm32f405"
BUILD = [
    "cargo", "build", "--quiet", "--package", "images", "--profile", "firmware", "--bin", "stm32f405",
    "--features", "stm32f405", "--target", TRIPLE, "--target-dir", str(TARGET),
]
LEAST_SHARE = 0.95
# The longest that the tests may take with a change. Unit: s.
LIMIT_S = 900


def copy_project():
    """Copies what git knows of the project, as it is now."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=PROJECT, check=True, capture_output=True, text=True)
    for name in listed.stdout.splitlines():
        source, place = PROJECT / name, COPY / name
        if source.is_file():
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, place)


def build():
    """Builds the image; whether it can be built."""
    kept = {name: value for name, value in os.environ.items() if name not in ("CARGO_ENCODED_RUSTFLAGS", "RUSTFLAGS")}
    done = subprocess.run(BUILD, cwd=COPY, env=kept, capture_output=True, text=True, check=False)
    if done.returncode == 0:
        subprocess.run(["cargo", "xtask", "seal", str(IMAGE)], cwd=PROJECT, env=kept, check=True)
    return done.returncode == 0, done.stderr


def is_caught(modules):
    """Whether a test fails: those that are likely to first, then all."""
    others = sorted(path.stem for path in HERE.glob("test_*.py") if path.stem not in modules)
    for names in (modules, others):
        if names:
            try:
                done = subprocess.run(
                    [sys.executable, "-m", "unittest", "-q", "-f", *names], cwd=HERE, check=False,
                    env={**os.environ, "MGPI_CHIP_IMAGE": str(IMAGE)}, capture_output=True, timeout=LIMIT_S,
                )
            except subprocess.TimeoutExpired:
                return "time"
            if done.returncode:
                failed = [line for line in done.stderr.decode().splitlines() if line.startswith(("FAIL", "ERROR"))]
                return failed[0].split()[1] if failed else "error"
    return None


def main():
    copy_project()
    is_built, said = build()
    if not is_built:
        sys.exit(said)
    if is_caught([]):
        sys.exit("the tests fail without a change")
    chosen = os.environ.get("MGPI_MUTANTS")
    numbers = {int(number) for number in chosen.split(",")} if chosen else None
    caught, survived, unexplained, unbuilt = 0, [], [], []
    with open(HERE / "mutants.csv", newline="", encoding="utf-8") as file:
        for number, mutant in enumerate(csv.DictReader(file), 1):
            if numbers is not None and number not in numbers:
                continue
            place = COPY / "firmware" / mutant["file"]
            text = place.read_text(encoding="utf-8")
            was, becomes = (mutant[name].replace("\\n", "\n") for name in ("was", "becomes"))
            shown = f"{number:3} {mutant['file']}: `{mutant['was']}` -> `{mutant['becomes']}`"
            if text.count(was) != 1:
                sys.exit(f"{shown}: stands there {text.count(was)} times")
            place.write_text(text.replace(was, becomes), encoding="utf-8")
            is_built, said = build()
            place.write_text(text, encoding="utf-8")
            if not is_built:
                unbuilt.append(shown)
                print(f"{shown}: cannot be built\n{said}", flush=True)
                continue
            by = is_caught(mutant["tests"].split())
            caught += by is not None
            if by is None:
                survived.append(shown)
                unexplained += [] if mutant["reason"] else [shown]
            print(f"{shown}: {f'caught by {by}' if by else 'survives'}", flush=True)
    count = caught + len(survived)
    print(f"{caught} of {count} changes are caught, {100 * caught / max(count, 1):.1f} %")
    for shown in unexplained:
        print(f"without a reason: {shown}")
    for shown in unbuilt:
        print(f"not built: {shown}")
    sys.exit(bool(unexplained or unbuilt) or caught < LEAST_SHARE * count)


if __name__ == "__main__":
    try:
        main()
    finally:
        shutil.rmtree(COPY)
