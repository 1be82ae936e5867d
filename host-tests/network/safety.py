"""What is lost between a client and its boards, at random moments: whether every board gets safe by itself.

    python safety.py MGPI MODEL.toml --runs 100 --seed 1

Four boards without hardware (`mgpi fleet`), each line behind a cable that can be pulled; `mgpi gateway`, a router, and
a client that moves all boards. Of each kind of loss so many runs; then everything goes on without a restart of
anything that was not lost. Prints a line of JSON a kind, and ends with 1 if one run has gone wrong.
"""

import argparse
import json
import multiprocessing
import os
import random
import select
import subprocess
import sys
import tempfile
import threading
import time
import tty

import zenoh
from client import session

NAME, UNITS = "lab", {"line-1": [1, 2], "line-2": [3, 4]}
# bus_silent_ticks of a board, and what a machine that does much else may add to a round of a line. Unit: s.
SILENT_S, LATE_S = 0.5, 0.4
# Bytes of an answer in a slot.
ANSWER_BYTES = 37
# How often the start of all boards is tried before a loss.
STARTS = 10


class Cable(threading.Thread):
    """A line's port behind another: what goes through may be held back."""

    def __init__(self, board_side, port):
        super().__init__(daemon=True)
        self.ours, theirs = os.openpty()
        tty.setraw(self.ours)
        tty.setraw(theirs)
        os.symlink(os.ttyname(theirs), port)
        self.board = os.open(board_side, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.board)
        self.is_pulled = False
        # A board whose answers do not come through.
        self.silenced = None
        # What has come of an answer in a slot.
        self.part = b""
        self.start()

    def run(self):
        try:
            self.carry()
        except OSError:
            # One of the ends is gone: the lab is closed.
            pass

    def carry(self):
        asked = 0
        while True:
            for end in select.select([self.ours, self.board], [], [])[0]:
                content = os.read(end, 4096)
                if end == self.ours:
                    asked, self.part = content[0], b""
                else:
                    content = self.heard(content, asked)
                if content and not self.is_pulled:
                    os.write(self.board if end == self.ours else self.ours, content)

    def heard(self, content, asked):
        """What of the boards' bytes comes through: no answer of the silenced one, asked by itself or in its slot."""
        if self.silenced is None or asked not in (0, self.silenced):
            return content
        if asked == self.silenced:
            return b""
        self.part += content
        whole = len(self.part) // ANSWER_BYTES * ANSWER_BYTES
        answers = [self.part[at : at + ANSWER_BYTES] for at in range(0, whole, ANSWER_BYTES)]
        self.part = self.part[whole:]
        return b"".join(answer for answer in answers if answer[0] != self.silenced)


def router(end_point):
    """A router, until it is killed."""
    config = zenoh.Config()
    config.insert_json5("mode", '"router"')
    config.insert_json5("listen/endpoints", json.dumps([end_point]))
    config.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(config):
        time.sleep(1e9)


class Lab:
    """Everything, until it is closed."""

    def __init__(self, mgpi, model):
        self.mgpi, self.folder = mgpi, tempfile.mkdtemp()
        os.chdir(self.folder)
        self.run("fleet", "boards", "--boards", "4", "--lines", "2", "--background")
        for line, units in UNITS.items():
            for unit in units:
                self.run("deploy", model, "--port", f"boards/{line}", "--unit", str(unit), "--force")
        self.cables = {line: Cable(f"boards/{line}", line) for line in UNITS}
        with open("lines.toml", "w") as file:
            for line, units in UNITS.items():
                file.write(f'[[line]]\nname = "{line}"\nport = "{line}"\nboards = {units}\n')
        self.port = 20000 + random.SystemRandom().randrange(20000)
        self.start_router()
        self.start_gateway()
        self.session, self.told, self.lock = session(self.end_point()), {}, threading.Lock()
        self.subscriber = self.session.declare_subscriber(f"mgpi/1/{NAME}/*/*/telemetry", self.heard)

    def end_point(self):
        return f"tcp/127.0.0.1:{self.port}"

    def run(self, *arguments):
        subprocess.run([self.mgpi, *arguments], check=True, stdout=subprocess.DEVNULL)

    def start_router(self):
        self.router = multiprocessing.get_context("spawn").Process(target=router, args=(self.end_point(),), daemon=True)
        self.router.start()
        time.sleep(1.0)

    def start_gateway(self):
        arguments = ["gateway", "lines.toml", "--http", "127.0.0.1:0", "--name", NAME]
        self.gateway = subprocess.Popen(
            [self.mgpi, *arguments, "--zenoh-connect", self.end_point()], stdout=subprocess.DEVNULL
        )

    def heard(self, sample):
        told = json.loads(sample.payload.to_bytes())
        with self.lock:
            self.told[str(sample.key_expr).rsplit("/", 1)[0]] = (time.time(), told)

    def states(self):
        """How each board was last seen, and how long ago."""
        with self.lock:
            return {key: (time.time() - when, told["state"], told["fault"]) for key, (when, told) in self.told.items()}

    def wait(self, what, is_so, limit_s=30.0):
        begin = time.time()
        while not is_so():
            if time.time() - begin > limit_s:
                raise AssertionError(f"{what}: {self.states()}")
            time.sleep(0.01)

    def order(self, what, of="*/*"):
        """What boards answer to an order, and what they refuse."""
        key = f"mgpi/1/{NAME}/{of}/order"
        done, refused = {}, {}
        for reply in self.session.get(key, payload=json.dumps({"order": what}), timeout=10.0):
            told = json.loads((reply.ok or reply.err).payload.to_bytes())
            if reply.ok is not None:
                done[str(reply.ok.key_expr).rsplit("/", 1)[0]] = told
            else:
                refused[told["key"]] = told["reason"]
        return done, refused

    def drive(self):
        """Starts all boards and moves them, in a thread, until the event that is answered."""
        for _ in range(STARTS):
            grants, refused = self.start()
            if len(grants) == 4:
                ended = threading.Event()
                threading.Thread(target=self.send, args=(grants, ended), daemon=True).start()
                try:
                    self.wait("all boards track", lambda: self.all_are("Tracking"), 5.0)
                    return ended
                except AssertionError as error:
                    ended.set()
                    refused = error
            # On a machine that does much else a board may vent before the last has started.
            self.order("stop")
        raise AssertionError(f"not all boards could be started: {refused}")

    def send(self, grants, ended):
        """Set points for these boards until it is ended."""
        sequence, begin = 0, time.time()
        while not ended.is_set():
            sequence += 1
            for key, grant in grants.items():
                wanted = 5.0 + min(10.0 * (time.time() - begin), 20.0)
                point = {"grant": grant, "sequence": sequence, "setpoint_mm": wanted, "sent_s": time.time()}
                self.session.put(f"{key}/setpoint", json.dumps(point))
            time.sleep(0.02)

    def start(self):
        """Starts all boards, as soon as they are ready: the grants, and what is refused."""
        self.wait("all boards are seen", lambda: len(self.fresh()) == 4)
        if any(state == "Fault" for _, state, _ in self.states().values()):
            self.order("acknowledge")
        self.wait("all boards are ready", lambda: self.all_are("Ready"))
        done, refused = self.order("start")
        return {key: told["grant"] for key, told in done.items()}, refused

    def fresh(self):
        return {key: state for key, (age_s, state, _) in self.states().items() if age_s < 0.5}

    def all_are(self, wanted):
        fresh = self.fresh()
        return len(fresh) == 4 and all(state == wanted for state in fresh.values())

    def vented(self, keys=None):
        """Whether all of these boards tell now that they have vented since their host was silent."""
        states = {key: told for key, told in self.states().items() if keys is None or key in keys}
        return all(age_s < 0.5 and (state, fault) == ("Fault", 21) for age_s, state, fault in states.values())

    def close(self):
        self.session.close()
        self.gateway.terminate()
        self.router.kill()
        self.run("fleet", "boards", "--stop")


def gateway_killed(lab, chance):
    """Its successor, which drives nothing, finds the boards vented."""
    lab.gateway.kill()
    lab.gateway.wait()
    lost = time.time()
    lab.start_gateway()
    time.sleep(max(0.0, lost + SILENT_S + LATE_S - time.time()))
    lab.wait("the boards are seen again", lambda: len(lab.fresh()) == 4)
    assert lab.vented(), lab.states()


def router_killed(lab, chance):
    """Gateway and client find its successor by themselves."""
    lab.router.kill()
    lab.router.join()
    time.sleep(SILENT_S + LATE_S)
    lab.start_router()
    lab.wait("the boards are seen again", lambda: len(lab.fresh()) == 4)
    assert lab.vented(), lab.states()


def line_pulled(lab, chance):
    """The other line goes on; the boards of this one have vented when it is there again."""
    line = chance.choice(sorted(UNITS))
    lab.cables[line].is_pulled = True
    time.sleep(SILENT_S + LATE_S)
    others = [state for key, state in lab.fresh().items() if f"/{line}/" not in key]
    lab.cables[line].is_pulled = False
    assert others == ["Tracking"] * 2, lab.states()
    keys = [key for key in lab.told if f"/{line}/" in key]
    lab.wait("the line is seen again", lambda: all(key in lab.fresh() for key in keys))
    assert lab.vented(keys), lab.states()


def board_silenced(lab, chance):
    """A board whose answers are lost is driven no more; the others go on."""
    line = chance.choice(sorted(UNITS))
    unit = chance.choice(UNITS[line])
    key = f"mgpi/1/{NAME}/{line}/{unit}"
    lab.cables[line].silenced = unit
    # Three questions without an answer, then its own patience; the others' rounds are longer meanwhile.
    time.sleep(SILENT_S + 2 * LATE_S)
    others = [state for other, state in lab.fresh().items() if other != key]
    lab.cables[line].silenced = None
    assert others == ["Tracking"] * 3, lab.states()
    lab.wait("the board is seen again", lambda: key in lab.fresh())
    assert lab.vented([key]), lab.states()


def flood(end_point, keys, seed):
    """Set points of no grant, old ones and rubbish, as fast as they go out, for a second."""
    chance, sent, end = random.Random(seed), 0, time.time() + 1.0
    with session(end_point) as on:
        while time.time() < end:
            for key in keys:
                old = {"grant": chance.randrange(2**32), "sequence": sent, "setpoint_mm": 60.0, "sent_s": time.time() - 9.0}
                on.put(f"{key}/setpoint", json.dumps(old) if sent % 2 else chance.randbytes(chance.randrange(300)))
                sent += 1


def client_floods(lab, chance):
    """The others track on, or vent, where the machine is too busy to carry their set points."""
    arguments = (lab.end_point(), sorted(lab.told), chance.random())
    flooding = multiprocessing.get_context("spawn").Process(target=flood, args=arguments, daemon=True)
    flooding.start()
    flooding.join()
    time.sleep(SILENT_S + LATE_S)
    lab.wait("all boards are seen", lambda: len(lab.fresh()) == 4)
    for _, state, fault in lab.states().values():
        assert (state, fault) in {("Tracking", 0), ("Fault", 21)}, lab.states()


LOSSES = [gateway_killed, router_killed, line_pulled, board_silenced, client_floods]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mgpi")
    parser.add_argument("model")
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=[loss.__name__ for loss in LOSSES])
    arguments = parser.parse_args()
    chance, is_wrong = random.Random(arguments.seed), False
    lab = Lab(os.path.abspath(arguments.mgpi), os.path.abspath(arguments.model))
    try:
        for loss in LOSSES:
            if arguments.only not in (None, loss.__name__):
                continue
            safe, wrong = 0, []
            for run in range(arguments.runs):
                ended = lab.drive()
                time.sleep(chance.uniform(0.2, 1.0))
                try:
                    loss(lab, chance)
                    safe += 1
                except AssertionError as error:
                    wrong.append(f"run {run}: {error}")
                ended.set()
                # What is still driven vents since its client is silent.
                time.sleep(SILENT_S + LATE_S)
            print(json.dumps({"loss": loss.__name__, "runs": arguments.runs, "safe": safe, "wrong": wrong}), flush=True)
            is_wrong |= safe < arguments.runs
    finally:
        lab.close()
    return is_wrong


if __name__ == "__main__":
    sys.exit(main())
