"""The fleet's page in a browser without a window, for as long as is wanted: does its memory grow, does it say anything
wrong, is a fault shown at once, does it fit a telephone and a desk?

    python page.py MGPI MODEL.toml --minutes 30 --shots FOLDER

Sixteen boards without hardware on four lines, `mgpi gateway`, and Chromium, asked over its debugging pipe. Prints a line
of JSON, and ends with 1 if one of these is not so.
"""

import argparse
import base64
import json
import os
import select
import socket
import statistics
import subprocess
import sys
import tempfile
import time

from client import ROOT, order, session, wait

NAME, BOARDS, LINES = "lab", 16, 4
# How long after the board's own time of it a fault may be shown. Unit: s.
SHOWN_S = 0.5
# By how much what the page's script holds may grow: some events of 16 kB that came behind the collector. Unit: byte.
GROWS = 500_000
WIDTHS = (390, 1200)


class Browser:
    """Chromium with one page, until it is closed."""

    def __init__(self, program, folder):
        options = f"--headless --no-sandbox --disable-gpu --remote-debugging-pipe --user-data-dir={folder}"
        # The pipe is wanted at the numbers 3 and 4.
        line = f"exec {program} {options} about:blank 3<&0 4>&1 </dev/null >/dev/null 2>/dev/null"
        self.program = subprocess.Popen(["sh", "-c", line], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.out, self.come = self.program.stdin.fileno(), self.program.stdout.fileno()
        self.number, self.rest, self.wrong = 0, b"", []
        target = next(found for found in self.ask("Target.getTargets")["targetInfos"] if found["type"] == "page")
        self.page = self.ask("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Runtime", "Log", "Page", "Performance"):
            self.of_page(f"{domain}.enable")

    def ask(self, method, session_id=None, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if session_id:
            message["sessionId"] = session_id
        os.write(self.out, json.dumps(message).encode() + b"\0")
        while True:
            told = self.hear(30.0)
            assert told is not None, f"no answer to {method}"
            if told.get("id") == self.number:
                assert "error" not in told, told
                return told["result"]

    def of_page(self, method, **parameters):
        return self.ask(method, self.page, **parameters)

    def hear(self, limit_s):
        """The next message; what is wrong on the page is kept."""
        while b"\0" not in self.rest:
            if not select.select([self.come], [], [], limit_s)[0]:
                return None
            self.rest += os.read(self.come, 1 << 20)
        message, self.rest = self.rest.split(b"\0", 1)
        told = json.loads(message)
        kind, parameters = told.get("method"), told.get("params", {})
        is_error = kind == "Log.entryAdded" and parameters["entry"]["level"] == "error"
        is_error |= kind == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "assert")
        if is_error or kind == "Runtime.exceptionThrown":
            self.wrong.append(parameters)
        return told

    def value(self, script):
        return self.of_page("Runtime.evaluate", expression=script, returnByValue=True)["result"].get("value")

    def memory(self):
        """What the script holds, and elements, once nothing is held that is not used; what the process has."""
        self.of_page("HeapProfiler.collectGarbage")
        metrics = {told["name"]: told["value"] for told in self.of_page("Performance.getMetrics")["metrics"]}
        processes = self.ask("SystemInfo.getProcessInfo")["processInfo"]
        renderer = max(told["id"] for told in processes if told["type"] == "renderer")
        with open(f"/proc/{renderer}/statm") as statm:
            resident = int(statm.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        return {
            "script_bytes": int(metrics["JSHeapUsedSize"]),
            "elements": self.value("document.getElementsByTagName('*').length"),
            "listeners": int(metrics["JSEventListeners"]),
            "resident_bytes": resident,
        }

    def close(self):
        self.program.terminate()
        self.program.wait()


# Notes when each board's card is first marked as at fault.
WATCH = """
window.faults = {};
new MutationObserver(() => {
  for (const card of document.querySelectorAll(".board.fault")) {
    const name = card.querySelector("h2").firstChild.textContent.trim();
    window.faults[name] ??= Date.now() / 1e3;
  }
}).observe(document.getElementById("boards"), { subtree: true, attributes: true, attributeFilter: ["class"] });
"""


def shown_after(browser, end_point):
    """All boards are driven, and their client falls silent: how long after its fault is each shown?"""
    seen, faults = {}, {}

    def heard(sample):
        told = json.loads(sample.payload.to_bytes())
        seen[str(sample.key_expr)] = told["state"]
        if told["state"] == "Fault":
            faults.setdefault(told["name"], told["unix_s"])

    with session(end_point) as on, on.declare_subscriber(f"{ROOT}/{NAME}/*/*/telemetry", heard):
        wait("all boards are ready", lambda: len(seen) == BOARDS and set(seen.values()) == {"Ready"})
        browser.value(WATCH)
        started, refused = order(on, f"{ROOT}/{NAME}/*/*/order", "start")
        assert len(started) == BOARDS, refused
        wait("all boards have vented", lambda: len(faults) == BOARDS)
        time.sleep(1.0)
        shown = browser.value("window.faults")
        order(on, f"{ROOT}/{NAME}/*/*/order", "acknowledge")
    assert set(shown) == set(faults), (sorted(shown), sorted(faults))
    return max(shown[name] - faults[name] for name in faults)


def free_port():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mgpi")
    parser.add_argument("model")
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--shots", help="a folder for pictures of the page")
    parser.add_argument("--browser", default="chromium")
    arguments = parser.parse_args()
    mgpi, model = os.path.abspath(arguments.mgpi), os.path.abspath(arguments.model)
    shots = arguments.shots and os.path.abspath(arguments.shots)
    folder = tempfile.mkdtemp()
    os.chdir(folder)

    def run(*command):
        subprocess.run([mgpi, *command], check=True, stdout=subprocess.DEVNULL)

    run("fleet", "boards", "--boards", str(BOARDS), "--lines", str(LINES), "--background")
    each = BOARDS // LINES
    with open("lines.toml", "w") as file:
        for line in range(1, LINES + 1):
            units = list(range(each * (line - 1) + 1, each * line + 1))
            for unit in units:
                run("deploy", model, "--port", f"boards/line-{line}", "--unit", str(unit), "--force")
            file.write(f'[[line]]\nport = "boards/line-{line}"\nboards = {units}\n')
    end_point, address = f"tcp/127.0.0.1:{free_port()}", f"127.0.0.1:{free_port()}"
    command = [mgpi, "gateway", "lines.toml", "--http", address, "--zenoh", end_point]
    gateway = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    time.sleep(3.0)
    browser = Browser(arguments.browser, os.path.join(folder, "profile"))
    try:
        browser.of_page("Page.navigate", url=f"http://{address}/")
        wait("the page shows all boards", lambda: browser.value("document.querySelectorAll('.board').length") == BOARDS)
        shown_s = shown_after(browser, end_point)
        too_wide = []
        for width in WIDTHS:
            browser.of_page("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=width < 600)
            time.sleep(1.0)
            if browser.value("document.documentElement.scrollWidth") > width:
                too_wide.append(width)
            if shots:
                os.makedirs(shots, exist_ok=True)
                picture = browser.of_page("Page.captureScreenshot", captureBeyondViewport=True)["data"]
                with open(os.path.join(shots, f"fleet-{width}.png"), "wb") as file:
                    file.write(base64.b64decode(picture))
        # What the page has made at its beginning is there for good.
        time.sleep(10.0)
        begin, memory = time.time(), [browser.memory()]
        while time.time() - begin < 60.0 * arguments.minutes:
            until = min(time.time() + 60.0, begin + 60.0 * arguments.minutes)
            while time.time() < until:
                browser.hear(1.0)
            memory.append(browser.memory())
        text = browser.value("document.getElementById('summary').textContent")
    finally:
        browser.close()
        gateway.terminate()
        run("fleet", "boards", "--stop")
    first, last = memory[0], memory[-1]
    # By the medians of the first and the last third: what comes between collector and look is chance.
    third = max(len(memory) // 3, 1)
    early, late = (statistics.median(told["script_bytes"] for told in part) for part in (memory[:third], memory[-third:]))
    told = {
        "minutes": arguments.minutes,
        "first": first,
        "last": last,
        "script_bytes_early_late": [early, late],
        "summary": text,
        "console_errors": len(browser.wrong),
        "wrong": browser.wrong[:3],
        "too_wide": too_wide,
        "fault_shown_after_s": shown_s,
        "load": os.getloadavg(),
    }
    print(json.dumps(told))
    has_grown = late > early + GROWS or last["elements"] > first["elements"] or last["listeners"] > first["listeners"]
    return bool(has_grown or browser.wrong or too_wide or shown_s > SHOWN_S)


if __name__ == "__main__":
    sys.exit(main())
