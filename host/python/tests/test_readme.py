"""The lines of the README and the notebook run as they stand."""

import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).parents[3]


def run(script, folder):
    (folder / "recordings").symlink_to(ROOT / "recordings")
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, env={**os.environ, "MPLBACKEND": "Agg"}
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_lines_of_the_readme_run(tmp_path):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "host/python/README.md").read_text(), re.DOTALL)
    assert blocks
    run("\n".join(blocks), tmp_path)
    assert (tmp_path / "muscle.toml").exists()


def test_the_notebook_runs(tmp_path):
    run((ROOT / "examples/python/first_model.py").read_text(), tmp_path)
