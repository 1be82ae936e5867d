"""Files that other programs have written are the CSV."""

import io

import numpy as np
import openpyxl
import pandas as pd
import pytest
import scipy.io

MAP = "time=t:s,pressure=p:bar,contraction=x:mm"


@pytest.fixture(scope="module")
def table(recordings):
    """A part of a recording under a researcher's own names."""
    frame = pd.read_csv(recordings / "rig-fig8.csv", comment="#").iloc[::10].reset_index(drop=True)
    frame = frame[["time_s", "pressure_bar", "contraction_mm"]]
    return frame.rename(columns={"time_s": "t", "pressure_bar": "p", "contraction_mm": "x"})


def npz(table, file):
    np.savez_compressed(file, **{name: table[name].to_numpy() for name in table}, rate_hz=np.array([100.0]))


def npy(table, file):
    np.save(file, table.to_records(index=False))


def mat(table, file):
    variables = {name: table[name].to_numpy() for name in table}
    scipy.io.savemat(file, {**variables, "rate_hz": 100.0, "note": "a text"}, do_compression=True)


def mat_of_columns(table, file):
    scipy.io.savemat(file, {name: table[[name]].to_numpy() for name in table}, oned_as="column")


def xlsx(table, file):
    table.to_excel(file, index=False)


def xlsx_with_units(table, file):
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(list(table))
    sheet.append(["s", "bar", "mm"])
    for row in table.itertuples(index=False):
        sheet.append(list(row))
    book.save(file)


@pytest.mark.parametrize(
    ("write", "ending"),
    [(npz, "npz"), (npy, "npy"), (mat, "mat"), (mat_of_columns, "mat"), (xlsx, "xlsx"), (xlsx_with_units, "xlsx")],
)
def test_a_file_of_another_program_has_the_diagnosis_of_the_csv(command, table, tmp_path, write, ending):
    names = {"t": "time_s", "p": "pressure_bar", "x": "contraction_mm"}
    wanted, file, out = tmp_path / "wanted.csv", tmp_path / f"file.{ending}", tmp_path / "rec.csv"
    table.rename(columns=names).to_csv(wanted, index=False)
    write(table, file)
    command("import", file, "--map", MAP, "-o", out)
    ours, theirs = pd.read_csv(out), pd.read_csv(wanted)
    assert list(ours) == list(theirs)
    # The same bits, so that whatever is made of them is the same; of one it is shown.
    assert np.array_equal(ours.to_numpy(), theirs.to_numpy())
    if ending != "mat":
        return
    arguments = ["--json", tmp_path / "d.json", "--force"]
    results = [command("diagnose", csv, *arguments, json_file=arguments[1]) for csv in (out, wanted)]
    for result in results:
        result.pop("seconds")
    assert results[0] == results[1]


def refused(program, *arguments):
    import subprocess

    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 2, done
    return done.stderr


def test_what_is_wrong_is_said_and_nothing_is_written(command, table, tmp_path):
    import os

    program = os.environ["MGPI_COMMAND"]
    file, out = tmp_path / "file.mat", tmp_path / "rec.csv"
    mat(table, file)
    assert "no column q" in refused(program, "import", file, "--map", "pressure=q", "-o", out)
    # One value, as the number of variables of another length has.
    assert "rate_hz" in command("import", file) and "of another length" in command("import", file)
    assert "has 1 values" in refused(program, "import", file, "--map", "time=rate_hz", "-o", out)
    whole = file.read_bytes()
    for length in (100, 140, len(whole) // 2, len(whole) - 7):
        file.write_bytes(whole[:length])
        message = refused(program, "import", file, "--map", MAP, "-o", out)
        assert "file.mat" in message, message
    buffer = io.BytesIO()
    table.to_excel(buffer, index=False)
    book = tmp_path / "book.xlsx"
    book.write_bytes(buffer.getvalue()[:-50])
    assert "book.xlsx: cut off or damaged" in refused(program, "import", book, "-o", out)
    book.write_bytes(buffer.getvalue())
    assert "there is no sheet monday; there are Sheet1" in refused(program, "import", book, "--sheet", "monday")
    text = tmp_path / "text.npy"
    np.save(text, np.array(["a", "b"]))
    assert "none of real numbers" in refused(program, "import", text)
    (tmp_path / "rec.parquet").write_bytes(b"PAR1 and so on")
    assert "pandas.read_parquet" in refused(program, "import", tmp_path / "rec.parquet")
    assert not out.exists()
