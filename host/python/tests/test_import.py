"""Files that other programs have written are the CSV."""

import io
import json
import os
import subprocess
import sys

import h5py
import mcap.writer
import numpy as np
import openpyxl
import pandas as pd
import pytest
import rosbags.rosbag2
import scipy.io
from mcap_ros2.writer import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore

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


def parquet(table, file):
    table.assign(note="text", count=np.arange(len(table), dtype="uint32")).to_parquet(file)


def parquet_of_many_groups(table, file):
    stamps = pd.to_datetime(1_700_000_000_000_000_000 + (table["t"] * 1e9).round().astype("int64"), unit="ns")
    table.assign(t=stamps).to_parquet(file, compression="zstd", row_group_size=77)


def hdf5(table, file):
    with h5py.File(file, "w") as book:
        for name in table:
            book.create_dataset(name, data=table[name].to_numpy(), chunks=(100,), compression="gzip", shuffle=True)
        # Of more numbers than a machine has memory for, of which none is ever written.
        book.create_dataset("camera/pictures", shape=(2000, 1000, 1000), dtype="f8")
        book.create_dataset("note", data="a text")


def hdf5_table(table, file):
    with h5py.File(file, "w", libver="latest") as book:
        book.create_dataset("run", data=table.rename(columns=lambda name: name).to_records(index=False))


def mat73(table, file):
    """As MATLAB has it: a page before it, arrays the other way round, each with its class."""
    with h5py.File(file, "w", userblock_size=512) as book:
        for place, name in enumerate(table):
            values = table[name].to_numpy()
            data = book.create_dataset(name, data=values[None, :] if place % 2 else values[:, None])
            data.attrs["MATLAB_class"] = np.bytes_("double")
        text = book.create_dataset("note", data=np.zeros((len(table), 1), dtype="u2"))
        text.attrs["MATLAB_class"] = np.bytes_("char")
    with file.open("r+b") as page:
        page.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def mat73_in_chunks(table, file):
    with h5py.File(file, "w", userblock_size=512) as book:
        for name in table:
            values = table[name].to_numpy()[None, :]
            data = book.create_dataset(name, data=values, chunks=(1, 50_000), compression="gzip")
            data.attrs["MATLAB_class"] = np.bytes_("double")
    with file.open("r+b") as page:
        page.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


BEGIN_NS = 1_700_000_000_000_000_000


def stamps(table):
    return BEGIN_NS + (table["t"] * 1e9).round().astype("int64").to_numpy()


def mcap_ros2(table, file):
    """One topic of stamped pressures and one of lengths, written a little later than they are stamped."""
    with file.open("wb") as output:
        writer = Ros2Writer(output)
        header = "std_msgs/Header header\nfloat64 value\n" + "=" * 80 + "\nMSG: std_msgs/Header\n"
        header += "builtin_interfaces/Time stamp\nstring frame_id\n" + "=" * 80
        header += "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
        schema = writer.register_msgdef("lab_msgs/Stamped", header)
        for stamp, pressure, length in zip(stamps(table), table["p"], table["x"]):
            stamp = int(stamp)
            for topic, value in (("/p", pressure), ("/x", length)):
                header = {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": topic}
                message = {"header": header, "value": value}
                writer.write_message(topic, schema, message, log_time=stamp + 1_234_567)
        writer.finish()


def bag(table, folder):
    """Of rosbags: a folder, as `ros2 bag record` makes it."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    number = store.types["std_msgs/msg/Float64"]
    with rosbags.rosbag2.Writer(folder, version=9, storage_plugin=rosbags.rosbag2.StoragePlugin.MCAP) as writer:
        names = {"p": "/p", "x": "/x"}
        topics = {name: writer.add_connection(names[name], number.__msgtype__, typestore=store) for name in names}
        for row, stamp in zip(table.itertuples(), stamps(table)):
            for name, topic in topics.items():
                message = store.serialize_cdr(number(getattr(row, name)), number.__msgtype__)
                writer.write(topic, int(stamp), message)


def mcap_json(table, file):
    writer = mcap.writer.Writer(str(file), compression=mcap.writer.CompressionType.LZ4)
    writer.start()
    schema = writer.register_schema("state", "jsonschema", json.dumps({"type": "object"}).encode())
    channel = writer.register_channel("/state", "json", schema)
    for row, stamp in zip(table.itertuples(), stamps(table)):
        message = {"pressure": row.p, "lengths": [row.x, 0.0], "name": "a"}
        writer.add_message(channel, int(stamp), json.dumps(message).encode(), int(stamp))
    writer.finish()


MAP_TABLE = "time=run/t:s,pressure=run/p:bar,contraction=run/x:mm"
MAP_STAMPED = "pressure=/p.value:bar,contraction=/x.value:mm"
MAP_BAG = "pressure=/p:bar,contraction=/x:mm"
MAP_JSON = "pressure=/state.pressure:bar,contraction=/state.lengths_1:mm"


@pytest.mark.parametrize(
    ("write", "ending", "mapped"),
    [
        (npz, "npz", MAP),
        (npy, "npy", MAP),
        (mat, "mat", MAP),
        (mat_of_columns, "mat", MAP),
        (xlsx, "xlsx", MAP),
        (xlsx_with_units, "xlsx", MAP),
        (parquet, "parquet", MAP),
        (parquet_of_many_groups, "parquet", MAP),
        (hdf5, "h5", MAP),
        (hdf5_table, "h5", MAP_TABLE),
        (mat73, "mat", MAP),
        (mcap_ros2, "mcap", MAP_STAMPED),
        (bag, "bag", MAP_BAG),
        (mcap_json, "mcap", MAP_JSON),
    ],
)
def test_a_file_of_another_program_has_the_diagnosis_of_the_csv(command, table, tmp_path, write, ending, mapped):
    names = {"t": "time_s", "p": "pressure_bar", "x": "contraction_mm"}
    wanted, file, out = tmp_path / "wanted.csv", tmp_path / f"file.{ending}", tmp_path / "rec.csv"
    table.rename(columns=names).to_csv(wanted, index=False)
    write(table, file)
    command("import", file, "--map", mapped, "-o", out)
    ours, theirs = pd.read_csv(out), pd.read_csv(wanted)
    assert sorted(ours) == sorted(theirs)
    ours = ours[list(theirs)]
    # The same bits, so that whatever is made of them is the same; of some it is shown.
    assert np.array_equal(ours.to_numpy(), theirs.to_numpy())
    if write not in (mat, parquet, hdf5, mat73, bag):
        return
    arguments = ["--json", tmp_path / "d.json", "--force"]
    results = [command("diagnose", csv, *arguments, json_file=arguments[1]) for csv in (out, wanted)]
    for result in results:
        result.pop("seconds")
    assert results[0] == results[1]


@pytest.mark.parametrize("version", ["earliest", "latest"])
def test_columns_of_hdf5_keep_the_order_in_which_they_were_made_where_the_file_has_it(command, table, tmp_path, version):
    file, out = tmp_path / "file.h5", tmp_path / "rec.csv"
    with h5py.File(file, "w", libver=version, track_order=True) as book:
        for name, column in (("time_s", "t"), ("pressure_bar", "p"), ("contraction_mm", "x")):
            book[name] = table[column].to_numpy()
    command("import", file, "-o", out)
    assert list(pd.read_csv(out)) == ["time_s", "pressure_bar", "contraction_mm"]


def refused(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 2, done
    return done.stderr


def test_what_is_wrong_is_said_and_nothing_is_written(command, table, tmp_path):
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
    assert not out.exists()


def test_topics_of_different_rates_come_onto_one_clock(command, table, tmp_path):
    """Pressures three times as often as lengths, and a command that is sent when it changes."""
    writer = mcap.writer.Writer(str(tmp_path / "lab.mcap"))
    writer.start()
    channels = {}
    for topic in ("/p", "/x", "/u"):
        schema = writer.register_schema("number", "jsonschema", b"{}")
        channels[topic] = writer.register_channel(topic, "json", schema)

    def say(topic, time_ms, value):
        stamp = BEGIN_NS + time_ms * 1_000_000
        writer.add_message(channels[topic], stamp, json.dumps({"data": value}).encode(), stamp)

    for k in range(300):
        if not 150 <= k < 160:
            say("/p", 10 * k, float(k))
    for k in range(100):
        say("/x", 30 * k + 5, 0.1 * k)
    for time_ms, value in ((20, 1.0), (1000, 2.0)):
        say("/u", time_ms, value)
    writer.finish()
    listed = command("import", tmp_path / "lab.mcap")
    assert "/p (number): 290 messages, 100.0 Hz" in listed and "/x (number): 100 messages, 33.3 Hz" in listed, listed
    wanted = "command=/u:bar,pressure=/p:bar,contraction=/x:mm"
    said = command("import", tmp_path / "lab.mcap", "--map", wanted, "-o", tmp_path / "rec.csv")
    assert "clock: /x, 100 samples, by when messages were recorded" in said
    assert "/p: straight lines between messages, 4 samples missing" in said, said
    assert "/u: held from message to message, 1 samples missing" in said, said
    rows = pd.read_csv(tmp_path / "rec.csv")
    assert np.allclose(rows["time_s"], 0.03 * np.arange(100), atol=1e-12)
    assert np.array_equal(rows["contraction_mm"], 0.1 * np.arange(100))
    known = rows["pressure_bar"].notna()
    assert np.allclose(rows["pressure_bar"][known], (3 * np.arange(100) + 0.5)[known])
    assert list(np.flatnonzero(~known)) == [50, 51, 52, 53]
    assert np.isnan(rows["command_bar"][0]) and set(rows["command_bar"][1:34]) == {1.0} and rows["command_bar"][34] == 2.0
    said = command("import", tmp_path / "lab.mcap", "--map", wanted, "--clock", "/p", "-o", tmp_path / "fast.csv")
    assert "clock: /p, 290 samples" in said and len(pd.read_csv(tmp_path / "fast.csv")) == 290


def test_a_damaged_file_of_any_kind_is_refused_and_nothing_is_written(command, table, tmp_path):
    program, out = os.environ["MGPI_COMMAND"], tmp_path / "rec.csv"
    for write, ending in ((parquet, "parquet"), (hdf5, "h5"), (mat73, "mat"), (mcap_ros2, "mcap")):
        file = tmp_path / f"file.{ending}"
        write(table, file)
        whole = file.read_bytes()
        mapped = MAP_STAMPED if ending == "mcap" else MAP
        for length in (130, len(whole) // 3, len(whole) // 2, len(whole) - 9):
            file.write_bytes(whole[:length])
            message = refused(program, "import", file, "--map", mapped, "-o", out)
            assert f"file.{ending}" in message and "cut off or damaged" in message, (length, message)
        # Bytes that are others: refused, or read; never a crash.
        random = np.random.default_rng(5)
        for _ in range(20):
            spoilt = bytearray(whole)
            for place in random.integers(8, len(whole), 30):
                spoilt[place] ^= 1 << random.integers(8)
            file.write_bytes(spoilt)
            done = subprocess.run([program, "import", file], capture_output=True, text=True, timeout=60)
            assert done.returncode in (0, 2), done
        file.write_bytes(whole)
        message = refused(program, "import", file, "--map", "pressure=nothing:bar", "-o", out)
        assert "nothing" in message, message
    assert not out.exists()


def test_what_a_bag_does_not_hold_is_said(command, table, tmp_path):
    program, out = os.environ["MGPI_COMMAND"], tmp_path / "rec.csv"
    file = tmp_path / "lab.mcap"
    mcap_ros2(table.head(20), file)
    message = refused(program, "import", file, "--map", MAP_STAMPED, "--clock", "/camera", "-o", out)
    assert "there is no topic /camera with numbers; there are /p, /x" in message
    message = refused(program, "import", file, "--map", "pressure=/p.volume:bar", "-o", out)
    assert "there is no variable /p.volume; there are /p.value" in message, message
    writer = mcap.writer.Writer(str(tmp_path / "buffers.mcap"))
    writer.start()
    schema = writer.register_schema("Number", "protobuf", b"")
    writer.add_message(writer.register_channel("/n", "protobuf", schema), 0, b"\x09", 0)
    writer.finish()
    message = refused(program, "import", tmp_path / "buffers.mcap", "--map", "pressure=/n:bar", "-o", out)
    assert "/n: not read: messages in protobuf" in message
    (tmp_path / "old.db3").write_bytes(b"SQLite format 3\0" + bytes(100))
    assert "ros2 bag convert" in refused(program, "import", tmp_path / "old.db3")
    (tmp_path / "empty").mkdir()
    assert "without a .mcap file" in refused(program, "import", tmp_path / "empty")


def test_holes_are_those_of_the_csv(command, table, tmp_path):
    """A block of NaN in the output, one hole in the input."""
    rows = table.copy()
    rows.loc[200:260, "x"] = np.nan
    rows.loc[400, "p"] = np.nan
    parquet(rows, tmp_path / "rec.parquet")
    hdf5(rows, tmp_path / "rec.h5")
    names = {"t": "time_s", "p": "pressure_bar", "x": "contraction_mm"}
    rows.rename(columns=names).to_csv(tmp_path / "wanted.csv", index=False)
    for file in ("rec.parquet", "rec.h5"):
        command("import", tmp_path / file, "--map", MAP, "-o", tmp_path / "rec.csv", "--force")
        ours, theirs = pd.read_csv(tmp_path / "rec.csv"), pd.read_csv(tmp_path / "wanted.csv")
        assert np.array_equal(ours[list(theirs)].to_numpy(), theirs.to_numpy(), equal_nan=True)


MEASURE = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, check=True)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


def peak_kb(*command):
    """Memory of a command, at most. A small process starts it, since a child is held to have had its parent's."""
    return int(subprocess.check_output([sys.executable, "-c", MEASURE, *map(str, command)]))


@pytest.mark.parametrize(
    ("write", "ending", "mapped", "rows"),
    [
        (npz, "npz", MAP, 1_500_000),
        (npy, "npy", MAP, 1_500_000),
        (mat, "mat", MAP, 1_500_000),
        (parquet, "parquet", MAP, 1_500_000),
        (hdf5, "h5", MAP, 1_500_000),
        (hdf5_table, "h5", MAP_TABLE, 1_500_000),
        (mat73_in_chunks, "mat", MAP, 1_500_000),
        # Chunks and their buffers differ by some 1.5 MB, whatever the number of rows.
        (mcap_json, "mcap", MAP_JSON, 800_000),
    ],
)
def test_a_long_file_takes_the_memory_of_a_short_one(tmp_path, write, ending, mapped, rows):
    """Held, a row of the long ones would take 24 bytes."""
    program, taken = os.environ["MGPI_COMMAND"], []
    for count in (rows // 4, rows):
        t = np.arange(count) * 0.001
        frame = pd.DataFrame({"t": t, "p": np.sin(t), "x": np.cos(t)})
        file = tmp_path / f"file.{ending}"
        write(frame, file)
        taken.append(peak_kb(program, "import", file, "--map", mapped, "-o", tmp_path / f"{count}.csv"))
    assert taken[1] - taken[0] < 0.25 * 24 * (rows - rows // 4) / 1024, taken


def test_what_is_written_as_parquet_is_read_by_others_bit_for_bit(command, table, tmp_path):
    rows = table.copy()
    rows.loc[200:260, "x"] = np.nan
    parquet(rows, tmp_path / "rec.parquet")
    for output in ("ours.parquet", "ours.csv"):
        command("import", tmp_path / "rec.parquet", "--map", MAP, "-o", tmp_path / output)
    ours, text = pd.read_parquet(tmp_path / "ours.parquet"), pd.read_csv(tmp_path / "ours.csv")
    assert list(ours) == list(text) and (ours.dtypes == "float64").all()
    assert np.array_equal(ours["contraction_mm"].to_numpy(), rows["x"].to_numpy(), equal_nan=True)
    command("import", tmp_path / "ours.parquet", "-o", tmp_path / "back.csv")
    assert (tmp_path / "back.csv").read_text() == (tmp_path / "ours.csv").read_text()
