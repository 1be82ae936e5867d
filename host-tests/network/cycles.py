"""How often all boards of a line are told and asked: in slots and one by one, calculated and measured.

    python cycles.py MGPI --boards 16 --lines 4 --rate 1000000 --exchange slots --seconds 20

Boards without hardware (`mgpi fleet`, whose answers take their bytes' time and begin in whole ticks) and `mgpi gateway`,
which drives nothing. Prints a line of JSON, and ends with 1 if a question was lost.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
import urllib.request

BITS = 10
# Of a request in slots: without members, and each (wire/src/slots.rs); of an answer. Unit: byte.
EMPTY, MEMBER, SLOT = 9, 10, 37
# Of a question one by one (with a set point and a sign of life: 8 + 13), and of its answer. Unit: byte.
ASKED, TOLD, ANSWERED = 8, 21, 49
# Before each slot, and between two frames. Unit: s.
GAP_S, SILENCE_S = 500e-6, 1.75e-3


def calculated(boards, rate, exchange):
    """A round of a line by its frames' bytes and the silences alone; one by one also with set points."""
    byte_s = BITS / rate
    if exchange == "slots":
        frame = EMPTY + MEMBER * boards
        return frame * byte_s + boards * (GAP_S + SLOT * byte_s) + SILENCE_S
    return boards * ((TOLD + ANSWERED) * byte_s + SILENCE_S)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mgpi")
    parser.add_argument("--boards", type=int, default=16)
    parser.add_argument("--lines", type=int, default=4)
    parser.add_argument("--rate", type=int, default=115_200)
    parser.add_argument("--exchange", choices=["slots", "plain"], default="slots")
    parser.add_argument("--seconds", type=float, default=20.0)
    told = parser.parse_args()
    mgpi = os.path.abspath(told.mgpi)
    os.chdir(tempfile.mkdtemp())

    def run(*arguments):
        subprocess.run([mgpi, *arguments], check=True, stdout=subprocess.DEVNULL)

    run("fleet", "boards", "--boards", str(told.boards), "--lines", str(told.lines), "--background")
    try:
        share = [line * told.boards // told.lines for line in range(told.lines + 1)]
        with open("lines.toml", "w") as file:
            for line in range(told.lines):
                units = list(range(share[line] + 1, share[line + 1] + 1))
                for unit in units if told.rate != 115_200 else []:
                    port = f"boards/line-{line + 1}"
                    run("bus", "--port", port, "--unit", str(unit), "--set-baud", str(told.rate), "--take")
                file.write(f'[[line]]\nport = "boards/line-{line + 1}"\nrate_bit_per_s = {told.rate}\n')
                file.write(f'exchange = "{told.exchange}"\nboards = {units}\n')
        gateway = subprocess.Popen([mgpi, "gateway", "lines.toml", "--http", "127.0.0.1:0"], stdout=subprocess.PIPE, text=True)
        try:
            line = gateway.stdout.readline()
            while "http://" not in line:
                line = gateway.stdout.readline()
            page = line[line.index("http://"):].split()[0].rstrip("/,")

            def boards():
                return json.load(urllib.request.urlopen(f"{page}/fleet.json"))["boards"]

            # Who they are was asked, and whether they know slots.
            time.sleep(5.0)
            before, begin = boards(), time.time()
            time.sleep(told.seconds)
            after, took_s = boards(), time.time() - begin
        finally:
            gateway.terminate()
            gateway.wait()
    finally:
        run("fleet", "boards", "--stop")
    rates = [(new["answered"] - old["answered"]) / took_s for old, new in zip(before, after)]
    lost = sum(new["lost"] - old["lost"] for old, new in zip(before, after))
    of_line = calculated(-(-told.boards // told.lines), told.rate, told.exchange)
    print(json.dumps({
        "boards": told.boards, "lines": told.lines, "rate_bit_per_s": told.rate, "exchange": told.exchange,
        "calculated_round_ms": round(1e3 * of_line, 2), "calculated_per_s": round(1 / of_line, 1),
        "measured_round_ms": round(1e3 / min(rates), 2), "measured_per_s": round(min(rates), 1),
        "answers": sum(new["answered"] - old["answered"] for old, new in zip(before, after)), "lost": lost,
    }))
    return lost > 0


if __name__ == "__main__":
    sys.exit(main())
