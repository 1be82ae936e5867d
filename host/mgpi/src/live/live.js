// Shows what the stream of events brings: rows [time, reference, contraction, pressure, command], and the status.
"use strict";
const SPAN_S = 30, LEAST_SPAN_S = 5, AIR = 0.05;
const KEPT_S = 60 * Number(document.currentScript.dataset.keptMinutes);
const COLUMNS = ["time_s", "reference_mm", "contraction_mm", "pressure_bar", "command_bar"];
const COUNTERS = ["ticks", "worst_tick_cycles", "mean_tick_cycles", "deadline_cycles", "overruns", "late_ticks",
  "limited_ticks", "bridged_samples", "resets", "bus_frames", "bus_damaged", "bus_refused"];
const GAINS = { kp_bar_per_mm: "kp {} bar/mm", ki_bar_per_mm_s: "ki {} bar/(mm s)", kd_bar_s_per_mm: "kd {} bar s/mm" };
const id = name => document.getElementById(name);
const html = (name, text) => Object.assign(document.createElement(name), { textContent: text });
const plots = Object.fromEntries(["contraction", "pressure", "loop", "error"]
  .map(name => [name, Plot.all.find(plot => id(name).contains(plot.drawing))]));

let rows = [], isDue = false, isPaused = false, hasEnded = false, isHeard = false;

// The ends of values, with some air; not too close together.
const ends = (values, least) => {
  let low = Infinity, high = -Infinity;
  for (const value of values) if (value !== null) { low = Math.min(low, value); high = Math.max(high, value); }
  if (low > high) [low, high] = [0, 0];
  const air = Math.max(AIR * (high - low), (least - (high - low)) / 2);
  return [low - air, high + air];
};
// Reference less contraction, as the controller has it; null where there is no reference.
const errorOf = row => row[1] === null ? null : row[1] - row[2];
const rootMeanSquare = rows => {
  const errors = rows.map(errorOf).filter(error => error !== null);
  return errors.length ? Math.sqrt(errors.reduce((sum, error) => sum + error * error, 0) / errors.length) : null;
};

const show = () => {
  isDue = false;
  if (!rows.length || isPaused) return;
  const last = rows[rows.length - 1], recent = rows.slice(rows.findIndex(row => row[0] >= last[0] - SPAN_S));
  const [time, reference, contraction, pressure, command] = [0, 1, 2, 3, 4].map(index => recent.map(row => row[index]));
  const window = [time[0], Math.max(time[0] + LEAST_SPAN_S, last[0])], error = recent.map(errorOf);
  const draw = (plot, x, endsX, lines, least) =>
    plot.set({ x: endsX, y: ends(lines.flat(), least) }, lines.map(y => ({ x, y })));
  draw(plots.contraction, time, window, [contraction, reference], 1);
  draw(plots.pressure, time, window, [pressure, command], 0.2);
  draw(plots.loop, pressure, ends(pressure, 0.2), [contraction], 1);
  draw(plots.error, time, window, [error], 1);
  const inWords = (rows, over) => {
    const rmse = rootMeanSquare(rows);
    return rmse === null ? null : `${rmse.toFixed(3)} mm over ${over}`;
  };
  const seen_s = (last[0] - rows[0][0]).toFixed(0);
  const said = [inWords(recent, `the last ${Math.min(SPAN_S, seen_s)} s`), inWords(rows, `all ${seen_s} s seen`)];
  id("rmse").textContent = said.every(words => words === null) ? "no reference is tracked"
    : said.filter(words => words !== null).join(", ");
  id("now").textContent = `${last[2].toFixed(2)} mm, ${last[3].toFixed(2)} bar`;
  id("save").disabled = false;
};

const problem = words => { id("problem").hidden = !words; id("problem").textContent = words; };
// Only a board that is heard can be stopped.
const hear = heard => {
  isHeard = heard && !hasEnded;
  id("stop").disabled = !isHeard;
  if (!isHeard) id("acknowledge").disabled = true;
};
const setState = (words, kind) => { id("state").textContent = words; id("state").className = kind; };
const end = () => {
  hasEnded = true;
  events.close();
  hear(false);
  for (const button of ["stop", "acknowledge", "pause"]) id(button).hidden = true;
  setState("Ended", "ended");
  problem("The run has ended: this page no longer shows or stops the board. What it has seen can still be saved.");
};

const tell = status => {
  if (status.ended) { end(); return; }
  problem(status.problem ?? "");
  if (status.problem) return;
  hear(true);
  const isDriven = ["Tracking", "Holding", "Service"].includes(status.state);
  setState(status.state, isDriven ? "driven" : status.fault ? "fault" : "");
  id("acknowledge").disabled = !status.fault;
  id("mode").textContent = status.mode ?? "–";
  id("gains").textContent = Object.entries(GAINS)
    .map(([name, words]) => words.replace("{}", Number(status[name].toPrecision(4)))).join(", ");
  const faults = status.occurred.flatMap(fault => {
    const isLatched = status.fault?.number === fault.number;
    return [
      html("dt", `${fault.number} ${fault.title}${isLatched ? ", latched" : ""}, ${fault.count} time${fault.count > 1 ? "s" : ""}`),
      html("dd", `Cause: ${fault.cause}. Cure: ${fault.cure}.`),
    ];
  });
  id("faults").replaceChildren(...(faults.length ? faults : [html("dt", "none since the start")]));
  id("counters").replaceChildren(...COUNTERS.map(name => html("li", `${name.replaceAll("_", " ")}: ${status[name]}`)));
};

const events = new EventSource("events");
events.onmessage = event => {
  const news = JSON.parse(event.data);
  // A board that was started anew counts from 0 again.
  if (news.rows.length && rows.length && news.rows[0][0] < rows[rows.length - 1][0]) rows = [];
  rows.push(...news.rows);
  const begin = rows.length ? rows[rows.length - 1][0] - KEPT_S : 0;
  if (rows.length && rows[0][0] < begin) rows = rows.filter(row => row[0] >= begin);
  if (news.status) tell(news.status);
  if (!isDue) { isDue = true; requestAnimationFrame(show); }
};
events.onerror = () => {
  hear(false);
  setState("No connection", "ended");
  problem("The program that serves this page has ended, or does not answer.");
};

const order = what => fetch(what, { method: "POST", headers: { "X-Mgpi-Order": "1" } })
  .then(answer => { if (!answer.ok) throw new Error(answer.statusText); })
  .catch(failure => problem(`The order was not heard: ${failure.message}`));
id("stop").addEventListener("click", () => order("stop"));
id("acknowledge").addEventListener("click", () => order("acknowledge"));
id("pause").addEventListener("click", () => {
  isPaused = !isPaused;
  id("pause").textContent = isPaused ? "Go on" : "Pause the page";
  id("pause").setAttribute("aria-pressed", isPaused);
  show();
});
const tableOfRows = () =>
  [COLUMNS.join(","), ...rows.map(row => row.map(value => value ?? "").join(",")), ""].join("\n");
id("save").addEventListener("click", () =>
  saveFile("board.csv", new Blob([tableOfRows()], { type: "text/csv" })));
