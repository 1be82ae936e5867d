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


def session(end_point, tls=None, password=None):
    config = zenoh.Config()
    if tls:
        config.insert_json5("transport/link/tls", json.dumps(tls))
    if password:
        for key, value in zip(("user", "password"), password):
            config.insert_json5(f"transport/auth/usrpwd/{key}", json.dumps(value))
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


class Driver:
    """A client that says that it lives, for all boards that it has a grant for, in a thread."""

    def __init__(self, on, name):
        self.on, self.name, self.grants, self.sequence, self.is_silent = on, name, {}, 0, threading.Event()
        self.wanted_mm = None
        threading.Thread(target=self.live, daemon=True).start()

    def live(self):
        while not self.is_silent.is_set():
            self.sequence += 1
            for key, grant in list(self.grants.items()):
                message = {"grant": grant, "sequence": self.sequence, "sent_s": time.time()}
                if self.wanted_mm is not None:
                    message["setpoint_mm"] = self.wanted_mm
                self.on.put(f"{key}/setpoint", json.dumps(message))
            time.sleep(0.02)

    def start(self, pattern):
        done, refused = order(self.on, f"{ROOT}/{self.name}/{pattern}/order", "start")
        self.grants.update({key.rsplit("/", 1)[0]: told["grant"] for key, told in done.items()})
        return refused


def ask(on, key, message):
    """The answer to a query, or the reason against it."""
    for reply in on.get(key, payload=json.dumps(message), timeout=10.0):
        if reply.ok is not None:
            return json.loads(reply.ok.payload.to_bytes())
        return json.loads(reply.err.payload.to_bytes())["reason"]
    return None


def wait(what, is_so, limit_s=20.0):
    begin = time.time()
    while not is_so():
        assert time.time() - begin < limit_s, what
        time.sleep(0.005)


def course(points, before, time_s):
    """The straight lines between points."""
    last = (0.0, before)
    for point in points:
        if time_s < point[0]:
            return last[1] + max(time_s - last[0], 0.0) / (point[0] - last[0]) * (point[1] - last[1])
        last = point
    return last[1]


def play(arguments):
    """A trajectory on all boards that begin at once; what is refused; and a client that dies in one."""
    seen, progress, errors, late, lock = {}, {}, {}, {}, threading.Lock()
    moving = {}
    root = f"{ROOT}/{arguments.name}"

    def heard(sample):
        told = json.loads(sample.payload.to_bytes())
        key = str(sample.key_expr).rsplit("/", 1)[0]
        with lock:
            seen[key] = told
            if key in moving and told["reference_mm"] is not None:
                points, before, start_s = moving[key]
                # What the board was asked for within the bound of the time at which it was so, and a tick.
                span = told["time_bound_s"] + 1e-3
                at = [course(points, before, told["unix_s"] - start_s + by) for by in (-span, 0.0, span)]
                error = max(min(at) - told["reference_mm"], told["reference_mm"] - max(at), 0.0)
                errors[key] = max(errors.get(key, 0.0), error)
                late[key] = late.get(key, 0) + 1

    def stepped(sample):
        told = json.loads(sample.payload.to_bytes())
        with lock:
            progress.setdefault(str(sample.key_expr).rsplit("/", 1)[0], []).append(told)

    def phases(key):
        with lock:
            return [told["phase"] for told in progress.get(key, [])]

    with session(arguments.end_point) as on:
        with on.declare_subscriber(f"{root}/*/*/telemetry", heard), on.declare_subscriber(f"{root}/*/*/trajectory", stepped):
            wait("all boards are seen", lambda: len(seen) == arguments.boards)
            driver = Driver(on, arguments.name)
            refused_starts = driver.start("*/*")
            names = {key: told["name"] for key, told in seen.items()}
            wait("all boards track", lambda: all(told["state"] == "Tracking" for told in seen.values()))
            time.sleep(0.3)
            points = [[1.0, 30.0], [2.0, 20.0], [4.0, 40.0], [arguments.seconds, 40.0]]

            def trajectory(start_s, points=points, parts=1, **changes):
                each = [{"board": names[key], "grant": grant, "points": points} for key, grant in driver.grants.items()]
                parts = parts * each
                parts[-1].update(changes)
                return ask(on, f"{root}/trajectory", {"start_s": start_s, "parts": parts})

            now = time.time()
            refused = [
                trajectory(now - 1.0),
                trajectory(now + 0.1),
                trajectory(now + 1e4),
                trajectory(now + 2.0, points=[[1.0, 900.0]]),
                trajectory(now + 2.0, points=[[1.0, 30.0], [0.5, 20.0]]),
                trajectory(now + 2.0, board="nobody"),
                trajectory(now + 2.0, grant=1),
                trajectory(now + 2.0, parts=2),
                ask(on, f"{root}/trajectory", {"begin_s": now}),
                ask(on, f"mgpi/0/{arguments.name}/trajectory", {}),
            ]
            time.sleep(0.3)
            undisturbed = all(told["state"] == "Tracking" for told in seen.values()) and not progress
            start_s = time.time() + 2.0
            with lock:
                for key in driver.grants:
                    moving[key] = (points, seen[key]["reference_mm"], start_s)
            answer = trajectory(start_s)
            assert answer == {"done": True, "start_s": answer["start_s"]} and abs(answer["start_s"] - start_s) < 1e-3, answer
            twice = trajectory(start_s + 1.0)
            is_over = lambda key: not {"done", "ended"}.isdisjoint(phases(key))
            wait("it is over", lambda: all(is_over(key) for key in driver.grants), arguments.seconds + 10.0)
            assert all("done" in phases(key) for key in driver.grants), progress
            with lock:
                moving.clear()
                playing = {key: next(told for told in steps if told["phase"] == "playing") for key, steps in progress.items()}
                underrun = max(told["underrun_ticks"] for steps in progress.values() for told in steps if told["phase"] == "done")
            lines = {}
            for key, told in playing.items():
                lines.setdefault(key.rsplit("/", 2)[1], []).append(told["start_tick"])
            starts = [told["start_s"] for told in playing.values()]
            # Set points go on where the trajectory has ended.
            driver.wanted_mm = 35.0
            wait("set points are taken again", lambda: all(abs((told["reference_mm"] or 0.0) - 35.0) < 1e-3 for told in seen.values()))
            driver.wanted_mm = None
            # A client that dies.
            with lock:
                progress.clear()
            answer = trajectory(None, [[0.5, 20.0], [30.0, 40.0]])
            wait("it plays", lambda: all("playing" in phases(key) for key in driver.grants))
            time.sleep(0.5)
            driver.is_silent.set()
            silent, vented = time.time(), {}

            def all_vented():
                with lock:
                    for key, told in seen.items():
                        if told["state"] == "Fault":
                            vented.setdefault(key, time.time() - silent)
                    return len(vented) == len(seen)

            wait("all boards vent", all_vented, 5.0)
            time.sleep(0.3)
            ended = sorted({told["reason"] for steps in progress.values() for told in steps if told["phase"] == "ended"})
    print(
        json.dumps(
            {
                "refused_starts": refused_starts,
                "refused": refused,
                "undisturbed": undisturbed,
                "twice": twice,
                "played": len(playing),
                "skew_ticks": max(max(ticks) - min(ticks) for ticks in lines.values()),
                "skew_s": max(starts) - min(starts),
                "start_off_s": max(abs(start - start_s) for start in starts),
                "start_bound_s": max(told["bound_s"] for told in playing.values()),
                "worst_reference_error_mm": max(errors.values()),
                "compared": min(late.values()),
                "underrun_ticks": underrun,
                "latest_vent_s": max(vented.values()),
                "faults": sorted({told["fault"] for told in seen.values()}),
                "ended": ended,
            }
        )
    )


def group(arguments):
    """A group is started, driven and stopped by one key."""
    seen, refused, lock = {}, [], threading.Lock()
    root = f"{ROOT}/{arguments.name}"

    def heard(sample):
        with lock:
            seen[str(sample.key_expr).rsplit("/", 1)[0]] = json.loads(sample.payload.to_bytes())

    def of_name(name):
        return next(told for told in list(seen.values()) if told["name"] == name)

    with session(arguments.end_point) as on:
        with on.declare_subscriber(f"{root}/*/*/telemetry", heard), on.declare_subscriber(
            f"{root}/*/*/refused", lambda sample: refused.append(json.loads(sample.payload.to_bytes())["reason"])
        ):
            wait("all boards are seen", lambda: len(seen) == arguments.boards)
            told = {"unknown": order(on, f"{root}/nobody/order", "start")}
            driver = Driver(on, arguments.name)
            told["refused_start"] = driver.start(arguments.group)
            told["twice"] = list(order(on, f"{root}/{arguments.group}/order", "start")[1].values())
            driver.wanted_mm = 25.0
            members, others = arguments.members.split(","), []
            wait("all track", lambda: all(of_name(name)["reference_mm"] == 25.0 for name in members))
            time.sleep(2.0)
            told["contractions_mm"] = [of_name(name)["contraction_mm"] for name in members]
            told["driven"] = sorted(board["name"] for board in seen.values() if board["state"] == "Tracking")
            told["stopped"] = list(order(on, f"{root}/{arguments.group}/order", "stop")[0].values())
            wait("all have vented", lambda: all(of_name(name)["state"] == "Ready" for name in members))
            time.sleep(0.2)
            told["refused"] = sorted({reason.split(":")[0] for reason in refused})
    print(json.dumps(told))


def halt(arguments):
    """All are stopped while they are started, one behind the other: which are driven afterwards."""
    seen, driven, lock = {}, set(), threading.Lock()
    stopped_s = [None]
    root = f"{ROOT}/{arguments.name}"

    def heard(sample):
        told, key = json.loads(sample.payload.to_bytes()), str(sample.key_expr).rsplit("/", 1)[0]
        with lock:
            seen[key] = told["state"]
            # What the boards told of the time before the stop may come a little later.
            if stopped_s[0] is not None and told["unix_s"] > stopped_s[0] + 0.4 and told["state"] == "Tracking":
                driven.add(key)

    with session(arguments.end_point) as on:
        with on.declare_subscriber(f"{root}/*/*/telemetry", heard):
            wait("all boards are seen", lambda: len(seen) == arguments.boards)
            answers = []
            start = threading.Thread(target=lambda: answers.append(order(on, f"{root}/*/*/order", "start")))
            start.start()
            wait("the first one tracks", lambda: "Tracking" in list(seen.values()))
            on.put(f"{root}/stop", "")
            stopped_s[0] = time.time()
            start.join()
            time.sleep(1.5)
    started, refused = answers[0]
    print(
        json.dumps(
            {
                "started": len(started),
                "refused": sorted(set(refused.values())),
                "driven": sorted(driven),
                "states": sorted(set(seen.values())),
            }
        )
    )


def reload(arguments):
    """The gateway reads its file again while boards are watched: what stays has no gap."""
    seen, gaps, lock = {}, {}, threading.Lock()
    root = f"{ROOT}/{arguments.name}"

    def heard(sample):
        now, told = time.time(), json.loads(sample.payload.to_bytes())
        with lock:
            key = str(sample.key_expr).rsplit("/", 1)[0]
            if key in seen:
                before = seen[key]
                lost, longest = gaps.get(key, (0, 0.0))
                gaps[key] = (lost + told["count"] - before[1] - 1, max(longest, told["unix_s"] - before[2]))
            seen[key] = (now, told["count"], told["unix_s"], told["state"], told["fault"])

    def fresh():
        with lock:
            return sorted(key for key, told in seen.items() if time.time() - told[0] < 0.5)

    with session(arguments.end_point) as on:
        with on.declare_subscriber(f"{root}/*/*/telemetry", heard):
            wait("the boards are seen", lambda: len(fresh()) == arguments.boards)
            driver = Driver(on, arguments.name)
            driver.start("*/*")
            time.sleep(1.0)
            before = fresh()
            with open(arguments.lines) as file:
                good = file.read()
            with open(arguments.lines, "w") as file:
                file.write(good.replace("boards = [", "boards = [0, ", 1))
            refused = ask(on, f"{root}/reload", {})
            time.sleep(0.5)
            after_bad = fresh()
            with open(arguments.new) as new, open(arguments.lines, "w") as file:
                file.write(new.read())
            with lock:
                gaps.clear()
            done = ask(on, f"{root}/reload", {})
            time.sleep(2.0)
            after = fresh()
            with lock:
                stay = [gaps[key] for key in after if key in before]
                states = {key: told[3] for key, told in seen.items() if key in before and key in after}
            alive = sorted(str(reply.ok.key_expr) for reply in on.liveliness().get(f"{root}/*/*/alive", timeout=5.0))
            driver.is_silent.set()
    print(
        json.dumps(
            {
                "before": before,
                "refused": refused,
                "after_bad": after_bad,
                "done": done,
                "after": after,
                "alive": alive,
                "lost": sum(lost for lost, _ in stay),
                "longest_gap_s": max(longest for _, longest in stay),
                "driven": sorted(key for key, state in states.items() if state == "Tracking"),
            }
        )
    )


def certificates(arguments):
    """An authority of one's own, a gateway and two clients that have certificates of it, and what each may do."""
    import os
    import subprocess

    os.makedirs(arguments.folder, exist_ok=True)

    def openssl(*command):
        subprocess.run(["openssl", *command], check=True, cwd=arguments.folder, stderr=subprocess.DEVNULL)

    key = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
    openssl("req", "-x509", *key, "-keyout", "ca.key", "-out", "ca.pem", "-days", "2", "-subj", "/CN=lab authority")
    for name in ("gateway", "driver", "viewer"):
        openssl("req", *key, "-keyout", f"{name}.key", "-out", f"{name}.csr", "-subj", f"/CN={name}")
        with open(os.path.join(arguments.folder, f"{name}.ext"), "w") as file:
            file.write("subjectAltName=DNS:localhost,IP:127.0.0.1\nbasicConstraints=CA:FALSE\n")
        signing = ["-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial", "-days", "2", "-extfile", f"{name}.ext"]
        openssl("x509", "-req", "-in", f"{name}.csr", "-out", f"{name}.pem", *signing)

    def path(name):
        return os.path.abspath(os.path.join(arguments.folder, name))

    drives = [f"{ROOT}/{arguments.name}/{what}" for what in ("*/*/order", "*/order", "*/*/setpoint", "*/setpoint", "trajectory", "reload", "stop")]
    config = {
        "listen": {"endpoints": [arguments.end_point]},
        "scouting": {"multicast": {"enabled": False}},
        "transport": {
            "link": {
                "tls": {
                    "root_ca_certificate": path("ca.pem"),
                    "listen_private_key": path("gateway.key"),
                    "listen_certificate": path("gateway.pem"),
                    "enable_mtls": True,
                }
            }
        },
        # Who has a certificate sees; who is called driver drives.
        "access_control": {
            "enabled": True,
            "default_permission": "allow",
            "rules": [
                {
                    "id": "no driving",
                    "permission": "deny",
                    "flows": ["ingress"],
                    "messages": ["put", "query"],
                    "key_exprs": drives,
                }
            ],
            "subjects": [{"id": "viewers", "cert_common_names": ["viewer"]}],
            "policies": [{"rules": ["no driving"], "subjects": ["viewers"]}],
        },
    }
    with open(path("gateway.json5"), "w") as file:
        json.dump(config, file, indent=2)


def secure(arguments):
    """Who has no certificate is not let in, who may only see does not drive, who may drive does."""
    import os

    def of(who):
        path = lambda name: os.path.abspath(os.path.join(arguments.folder, name))
        tls = {"root_ca_certificate": path("ca.pem")}
        if who:
            tls |= {"connect_private_key": path(f"{who}.key"), "connect_certificate": path(f"{who}.pem"), "enable_mtls": True}
        return tls

    told = {}
    for who in (None, "viewer", "driver"):
        seen = set()
        try:
            with session(arguments.end_point, of(who)) as on:
                with on.declare_subscriber(f"{ROOT}/{arguments.name}/*/*/telemetry", lambda sample: seen.add(str(sample.key_expr))):
                    time.sleep(2.0)
                    key, end = f"{ROOT}/{arguments.name}/*/*/order", time.time() + 5.0
                    # A query that nobody is known to answer yet ends at once; who may not ask is never answered.
                    while not any(answers := order(on, key, "start")) and time.time() < end:
                        time.sleep(0.2)
                    done, refused = answers
                    told[str(who)] = {"seen": len(seen), "started": len(done), "refused": len(refused)}
                    order(on, key, "stop")
        except zenoh.ZError as error:
            told[str(who)] = {"kept_out": "certificate" in str(error).lower() or "unable to connect" in str(error).lower()}
    print(json.dumps(told))


def passwords(arguments):
    """A gateway that lets in who has a password."""
    import os

    os.makedirs(arguments.folder, exist_ok=True)
    users = os.path.abspath(os.path.join(arguments.folder, "users.txt"))
    with open(users, "w") as file:
        file.write("driver:a long secret\n")
    config = {
        "listen": {"endpoints": [arguments.end_point]},
        "scouting": {"multicast": {"enabled": False}},
        "transport": {"auth": {"usrpwd": {"user": "gateway", "password": "its own", "dictionary_file": users}}},
    }
    with open(os.path.join(arguments.folder, "gateway.json5"), "w") as file:
        json.dump(config, file, indent=2)


def login(arguments):
    """Who has no password, or another, is not let in."""
    told = {}
    for who, password in (("nobody", None), ("wrong", ("driver", "a guess")), ("driver", ("driver", "a long secret"))):
        seen = set()
        try:
            with session(arguments.end_point, password=password) as on:
                with on.declare_subscriber(f"{ROOT}/{arguments.name}/*/*/telemetry", lambda sample: seen.add(str(sample.key_expr))):
                    time.sleep(2.0)
            told[who] = len(seen)
        except zenoh.ZError:
            told[who] = "kept out"
    print(json.dumps(told))


def attachment(sample):
    """What rmw_zenoh sends with each message: number, time, and who."""
    content = sample.attachment.to_bytes()
    assert len(content) == 33, len(content)
    number, time_ns = struct.unpack("<qq", content[:16])
    assert content[16] == 16
    return number, time_ns, content[17:]


def ros(arguments):
    """The topics and services of ROS 2: keys, tokens, hashes, messages."""
    import numpy
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
            type_name, type_hash = endpoints["MS", f"/{arguments.name}/joint_commands"]
            key = f"{arguments.domain}/{arguments.name}/joint_commands/{type_name}/{type_hash}"
            state_key = f"{arguments.domain}/{arguments.name}/joint_states/" + "/".join(endpoints["MP", f"/{arguments.name}/joint_states"])
            heard = []
            empty = numpy.array([], dtype=numpy.float64)

            def command(positions):
                """What `positions` answers for each number, 50 times a second for 5 s; where the joints are then."""
                with on.declare_subscriber(state_key, heard.append):
                    for number in range(250):
                        message = joint(header(stamp(0, 0), ""), told["joints"], positions(number), empty, empty)
                        content = struct.pack("<qq", number, time.time_ns()) + bytes([16]) + bytes(range(16))
                        on.put(key, bytes(types.serialize_cdr(message, "sensor_msgs/msg/JointState")), attachment=content)
                        time.sleep(0.02)
                last = types.deserialize_cdr(heard[-1].payload.to_bytes(), "sensor_msgs/msg/JointState")
                return [float(position) for position in last.position]

            told["moved_to_m"] = command(lambda number: numpy.full(len(told["joints"]), 0.03 * min(number / 150.0, 1.0)))
            # A trajectory, as a controller of ROS 2 is sent it; names alone say that its client lives.
            course, point = types.types["trajectory_msgs/msg/JointTrajectory"], types.types["trajectory_msgs/msg/JointTrajectoryPoint"]
            span = types.types["builtin_interfaces/msg/Duration"]
            type_name, type_hash = endpoints["MS", f"/{arguments.name}/joint_trajectory"]
            course_key = f"{arguments.domain}/{arguments.name}/joint_trajectory/{type_name}/{type_hash}"

            def send(joints):
                width = len(joints)
                points = [
                    point(numpy.full(width, to), empty, empty, empty, span(sec, 500_000_000)) for sec, to in [(0, 0.02), (1, 0.025)]
                ]
                content = struct.pack("<qq", 0, time.time_ns()) + bytes([16]) + bytes(range(16))
                message = course(header(stamp(0, 0), ""), joints, points)
                on.put(course_key, bytes(types.serialize_cdr(message, "trajectory_msgs/msg/JointTrajectory")), attachment=content)

            send([*told["joints"], "nobody"])
            send(told["joints"])
            told["played_to_m"] = command(lambda number: empty)
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
    several = [commands.add_parser(name) for name in ("play", "group", "reload", "halt")]
    for command in several:
        command.add_argument("--boards", type=int, default=4)
    several[0].add_argument("--seconds", type=float, default=6.0)
    several[1].add_argument("--group", default="left")
    several[1].add_argument("--members", default="")
    several[2].add_argument("--lines", default="lines.toml")
    several[2].add_argument("--new", default="new.toml")
    for name in ("certificates", "secure", "passwords"):
        commands.add_parser(name).add_argument("folder")
    commands.add_parser("login")
    commands.add_parser("ros")
    commands.add_parser("bag").add_argument("file")
    arguments = parser.parse_args()
    for command in (watch, drive, play, group, reload, halt, certificates, secure, passwords, login, ros, bag):
        if command.__name__ == arguments.command:
            command(arguments)


if __name__ == "__main__":
    sys.exit(main())
