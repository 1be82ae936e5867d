"""A gateway seen by programs that are not ours: Zenoh's own Python, rosbags, mcap, pamoja.

Each command prints a line of JSON and ends with 0, or says what is wrong and ends with 1.
"""

import argparse
import json
import struct
import sys
import threading
import time

import zenoh

ROOT = "mgpi/1"


def session(end_point):
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([end_point]))
    config.insert_json5("scouting/multicast/enabled", "false")
    return zenoh.open(config)


def watch(arguments):
    """Counts telemetry: per board how much came, how much was lost, and how late the latest was."""
    boards, lock = {}, threading.Lock()

    def heard(sample):
        now = time.time()
        told = json.loads(sample.payload.to_bytes())
        with lock:
            board = boards.setdefault(
                str(sample.key_expr), {"first": told["count"], "count": 0, "lost": 0, "last": None, "late_s": 0.0, "missed": 0}
            )
            if board["last"] is not None:
                board["lost"] += told["count"] - board["last"] - 1
            board["last"] = told["count"]
            board["count"] += 1
            board["missed"] = told["missed"]
            board["late_s"] = max(board["late_s"], now - told["unix_s"] - told["time_bound_s"])

    with session(arguments.end_point) as on:
        with on.declare_subscriber(f"{ROOT}/{arguments.name}/*/*/telemetry", heard):
            time.sleep(arguments.seconds)
    with lock:
        told = {
            "boards": len(boards),
            "messages": sum(board["count"] for board in boards.values()),
            "lost": sum(board["lost"] for board in boards.values()),
            "missed": sum(board["missed"] for board in boards.values()),
            "least_hz": min((board["count"] for board in boards.values()), default=0) / arguments.seconds,
            "latest_s": max((board["late_s"] for board in boards.values()), default=0.0),
        }
    print(json.dumps(told))


def order(on, key, what):
    """Answers of all boards to an order: those that are done, and those that refuse."""
    done, refused = {}, {}
    for reply in on.get(key, payload=json.dumps({"order": what}), timeout=10.0):
        if reply.ok is not None:
            done[str(reply.ok.key_expr)] = json.loads(reply.ok.payload.to_bytes())
        else:
            told = json.loads(reply.err.payload.to_bytes())
            refused[told["key"]] = told["reason"]
    return done, refused


def drive(arguments):
    """Starts all boards, moves them along a slow wave, stops sending, and waits for them to vent."""
    import math

    state, errors, lock, refused = {}, {}, threading.Lock(), []

    def heard(sample):
        told = json.loads(sample.payload.to_bytes())
        with lock:
            state[str(sample.key_expr).rsplit("/", 1)[0]] = told

    with session(arguments.end_point) as on:
        with on.declare_subscriber(f"{ROOT}/{arguments.name}/*/*/telemetry", heard), on.declare_subscriber(
            f"{ROOT}/{arguments.name}/*/*/refused", lambda sample: refused.append(json.loads(sample.payload.to_bytes()))
        ):
            time.sleep(1.0)
            done, said = order(on, f"{ROOT}/{arguments.name}/*/*/order", "start")
            grants = {key.rsplit("/", 1)[0]: told["grant"] for key, told in done.items()}
            begin, sequence = time.time(), 0
            while time.time() - begin < arguments.seconds:
                sequence += 1
                wanted = 25.0 + 15.0 * math.sin(0.5 * (time.time() - begin) - math.pi / 2)
                for key, grant in grants.items():
                    message = {"grant": grant, "sequence": sequence, "setpoint_mm": wanted, "sent_s": time.time()}
                    on.put(f"{key}/setpoint", json.dumps(message))
                time.sleep(0.02)
                if time.time() - begin > 2.0:
                    with lock:
                        for key in grants:
                            told = state[key]
                            if told["reference_mm"] is not None:
                                error = abs(told["reference_mm"] - told["contraction_mm"])
                                errors[key] = max(errors.get(key, 0.0), error)
            with lock:
                driven = {key: state[key]["state"] for key in grants}
            silent = time.time()
            vented = {}
            while time.time() - silent < 5.0 and len(vented) < len(grants):
                time.sleep(0.005)
                with lock:
                    for key in grants:
                        if state[key]["state"] == "Fault":
                            vented.setdefault(key, time.time() - silent)
            # What comes too late drives nothing.
            message = {"grant": next(iter(grants.values()), 0), "sequence": sequence + 1, "setpoint_mm": 30.0, "sent_s": time.time()}
            for key in grants:
                on.put(f"{key}/setpoint", json.dumps(message))
            time.sleep(0.5)
            with lock:
                faults = {key: state[key]["fault"] for key in grants}
    print(
        json.dumps(
            {
                "started": len(grants),
                "refused": said,
                "tracking": sum(name == "Tracking" for name in driven.values()),
                "worst_error_mm": max(errors.values(), default=None),
                "vented": len(vented),
                "latest_vent_s": max(vented.values(), default=None),
                "faults": sorted(set(faults.values())),
                "refused_set_points": sorted({told["reason"].split(":")[0] for told in refused}),
            }
        )
    )


def attachment(sample):
    """What rmw_zenoh sends with each message: number, time, and who."""
    content = sample.attachment.to_bytes()
    assert len(content) == 33, len(content)
    number, time_ns = struct.unpack("<qq", content[:16])
    assert content[16] == 16
    return number, time_ns, content[17:]


def ros(arguments):
    """The topics and services of ROS 2: keys, tokens, hashes, messages."""
    from rosbags.typesys import Stores, get_typestore

    types = get_typestore(Stores.ROS2_JAZZY)
    told = {}
    with session(arguments.end_point) as on:
        tokens = [str(reply.ok.key_expr) for reply in on.liveliness().get("@ros2_lv/**", timeout=5.0)]
        endpoints = {}
        for token in tokens:
            parts = token.split("/")
            assert parts[0] == "@ros2_lv" and parts[1] == str(arguments.domain), token
            kind, namespace, node = parts[5], parts[7], parts[8]
            assert (namespace, node) == (f"%{arguments.name}", "mgpi_gateway"), token
            if kind == "NN":
                continue
            topic, type_name, type_hash = parts[9].replace("%", "/"), parts[10], parts[11]
            endpoints[kind, topic] = (type_name, type_hash)
            if kind != "SS":
                package, name = type_name.split("::")[0], type_name.rsplit("::", 1)[1].rstrip("_")
                assert type_hash == types.hash_rihs01(f"{package}/msg/{name}"), token
        told["endpoints"] = sorted(f"{kind} {topic}" for kind, topic in endpoints)
        for kind, topic, name in [
            ("MP", f"/{arguments.name}/joint_states", "sensor_msgs/msg/JointState"),
            ("MP", "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"),
        ]:
            type_name, type_hash = endpoints[kind, topic]
            heard = []
            with on.declare_subscriber(f"{arguments.domain}{topic}/{type_name}/{type_hash}", heard.append):
                time.sleep(2.5)
            messages = [types.deserialize_cdr(sample.payload.to_bytes(), name) for sample in heard]
            numbers = [attachment(sample)[0] for sample in heard]
            assert numbers == list(range(numbers[0], numbers[0] + len(numbers))), numbers
            assert all(abs(1e-9 * attachment(sample)[1] - time.time()) < 5.0 for sample in heard)
            stamp = messages[-1].header.stamp
            assert abs(stamp.sec + 1e-9 * stamp.nanosec - time.time()) < 2.0, stamp
            told[topic] = len(messages)
            if name.endswith("JointState"):
                told["joints"] = list(messages[-1].name)
                told["positions_m"] = [float(position) for position in messages[-1].position]
            else:
                told["levels"] = [int(status.level) for status in messages[-1].status]

        def trigger(which):
            type_name, type_hash = endpoints["SS", f"/{arguments.name}/{which}"]
            key = f"{arguments.domain}/{arguments.name}/{which}/{type_name}/{type_hash}"
            content = struct.pack("<qq", 1, time.time_ns()) + bytes([16]) + bytes(range(16))
            replies = list(on.get(key, payload=bytes([0, 1, 0, 0, 0]), attachment=content, timeout=10.0))
            assert len(replies) == 1 and attachment(replies[0].ok)[2] == bytes(range(16)), replies
            answer = replies[0].ok.payload.to_bytes()
            assert answer[:4] == bytes([0, 1, 0, 0])
            length = struct.unpack("<I", answer[8:12])[0]
            return bool(answer[4]), answer[12 : 12 + length - 1].decode()

        told["start"] = trigger("start")
        if told["start"][0]:
            joint = types.types["sensor_msgs/msg/JointState"]
            header, stamp = types.types["std_msgs/msg/Header"], types.types["builtin_interfaces/msg/Time"]
            import numpy

            type_name, type_hash = endpoints["MS", f"/{arguments.name}/joint_commands"]
            key = f"{arguments.domain}/{arguments.name}/joint_commands/{type_name}/{type_hash}"
            state_key = f"{arguments.domain}/{arguments.name}/joint_states/" + "/".join(endpoints["MP", f"/{arguments.name}/joint_states"])
            heard = []
            empty = numpy.array([], dtype=numpy.float64)
            with on.declare_subscriber(state_key, heard.append):
                for number in range(250):
                    target = numpy.full(len(told["joints"]), 0.03 * min(number / 150.0, 1.0))
                    message = joint(header(stamp(0, 0), ""), told["joints"], target, empty, empty)
                    content = struct.pack("<qq", number, time.time_ns()) + bytes([16]) + bytes(range(16))
                    on.put(key, bytes(types.serialize_cdr(message, "sensor_msgs/msg/JointState")), attachment=content)
                    time.sleep(0.02)
            last = types.deserialize_cdr(heard[-1].payload.to_bytes(), "sensor_msgs/msg/JointState")
            told["moved_to_m"] = [float(position) for position in last.position]
            told["stop"] = trigger("stop")
    print(json.dumps(told))


def bag(arguments):
    """A recording, read by mcap and by rosbags."""
    from pathlib import Path

    from mcap_ros2.reader import read_ros2_messages
    from rosbags.highlevel import AnyReader

    counts, joints = {}, set()
    for message in read_ros2_messages(arguments.file):
        counts[message.channel.topic] = counts.get(message.channel.topic, 0) + 1
        if message.channel.topic.endswith("/joint_state"):
            joints.update(message.ros_msg.name)
    with AnyReader([Path(arguments.file)]) as reader:
        other, pressures = {}, []
        for connection, _, content in reader.messages():
            other[connection.topic] = other.get(connection.topic, 0) + 1
            message = reader.deserialize(content, connection.msgtype)
            if connection.topic.endswith("/pressure"):
                pressures.append(message.fluid_pressure)
    assert counts == other, (counts, other)
    print(json.dumps({"counts": counts, "joints": sorted(joints), "highest_pressure_pa": max(pressures, default=None)}))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--end-point", default="tcp/127.0.0.1:7447")
    parser.add_argument("--name", default="lab")
    parser.add_argument("--domain", type=int, default=0)
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("watch", "drive"):
        commands.add_parser(name).add_argument("--seconds", type=float, default=10.0)
    commands.add_parser("ros")
    commands.add_parser("bag").add_argument("file")
    arguments = parser.parse_args()
    {"watch": watch, "drive": drive, "ros": ros, "bag": bag}[arguments.command](arguments)


if __name__ == "__main__":
    sys.exit(main())
