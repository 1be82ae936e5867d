//! The Python package: its wheel, built as anybody builds it, in an environment that has nothing
//! else of ours, and its tests against the command.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::{host, run, setup};

/// Where the package is.
const PACKAGE: &str = "host/python";
/// Prints the size of what is installed and how long the import takes beside NumPy's.
const SIZE_AND_TIME: &str = "
import numpy, time
begin = time.perf_counter()
import mgpi, pathlib
took_ms = 1000.0 * (time.perf_counter() - begin)
size = sum(file.stat().st_size for file in pathlib.Path(mgpi.__file__).parent.rglob('*') if file.is_file())
print(f'mgpi {mgpi.__version__}: {size / 1e6:.1f} MB installed, import {took_ms:.0f} ms beside that of NumPy')
";

/// Builds the wheel, installs it in a clean environment, runs the README's lines and the notebook
/// there with NumPy alone, then the tests beside pandas, SciPy and scikit-learn.
///
/// # Errors
/// Python or a package cannot be had, the wheel cannot be built, or a test fails.
pub fn python() -> Result<()> {
    setup::ensure_python_package()?;
    host::build()?;
    let directory = run::target_dir().join("python");
    let wheel = run::step("wheel", || wheel(&directory.join("wheels")))?;
    let (bare, tools) = (directory.join("bare"), setup::PACKAGE_PYTHON.program());
    run::step("the README's lines and the notebook, with NumPy alone", || {
        clean(&bare, &wheel)?;
        let python = bare.join("bin/python");
        run::succeed(Command::new(&python).args(["-c", SIZE_AND_TIME]))?;
        // The tools' pytest, with the packages of the clean environment.
        run::succeed(Command::new(&python).args(["-c", RUN_LINES]).arg(run::root()).current_dir(&bare))
    })?;
    run::step("tests of the Python package", || {
        let install = ["-m", "pip", "install", "-q", "--force-reinstall", "--no-deps"];
        run::succeed(Command::new(&tools).args(install).arg(&wheel))?;
        let mut tests = Command::new(&tools);
        tests
            .args(["-m", "pytest", "-q", "-p", "no:cacheprovider"])
            .arg(run::root().join(PACKAGE).join("tests"));
        tests.env("MGPI_COMMAND", run::target_dir().join("debug/mgpi")).current_dir(&directory);
        run::succeed(&mut tests)
    })
}

/// Runs the Python lines of the README, and the notebook, beside the project's recordings.
const RUN_LINES: &str = r#"
import pathlib, re, sys, tempfile, os
root = pathlib.Path(sys.argv[1])
lines = re.findall(r"```python\n(.*?)```", (root / "host/python/README.md").read_text(), re.DOTALL)
assert lines, "the README has no Python"
notebook = (root / "examples/python/first_model.py").read_text()
for script in ["\n".join(lines), notebook]:
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        pathlib.Path("recordings").symlink_to(root / "recordings")
        exec(compile(script, "script", "exec"), {"__name__": "__main__"})
        os.chdir(root)
"#;

/// Builds the wheel in a folder of its own.
fn wheel(folder: &Path) -> Result<PathBuf> {
    // An older one would be taken for it.
    let _ = fs::remove_dir_all(folder);
    let mut maturin = Command::new(setup::PACKAGE_PYTHON.program().with_file_name("maturin"));
    // As the tests have everything, which is mostly built already.
    maturin.args(["build", "--quiet", "--profile", "dev", "--locked"]);
    maturin.arg("--manifest-path").arg(run::root().join(PACKAGE).join("Cargo.toml"));
    maturin.arg("--interpreter").arg(setup::PACKAGE_PYTHON.program()).arg("--out").arg(folder);
    run::succeed(&mut maturin)?;
    let files = fs::read_dir(folder).with_context(|| format!("cannot read {}", folder.display()))?;
    let wheels: Vec<PathBuf> = files
        .filter_map(|file| Some(file.ok()?.path()))
        .filter(|file| file.extension() == Some(OsStr::new("whl")))
        .collect();
    ensure!(wheels.len() == 1, "maturin made {} wheels", wheels.len());
    wheels.into_iter().next().context("a wheel")
}

/// Makes an environment that has the wheel, and what it asks for.
fn clean(folder: &Path, wheel: &Path) -> Result<()> {
    // What an earlier one has got would be in the way.
    let _ = fs::remove_dir_all(folder);
    run::succeed(Command::new("python3").args(["-m", "venv"]).arg(folder))?;
    let mut pip = Command::new(folder.join("bin/python"));
    run::succeed(pip.args(["-m", "pip", "install", "-q"]).arg(wheel))
}
