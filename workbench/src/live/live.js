// Draws what the stream of events brings: rows [time, wanted, contraction, pressure, command], and the status.
"use strict";
const SPAN_S = 30, LEAST_SPAN_S = 5, SIZE = { left: 86, top: 10, width: 539, height: 275 };
const COUNTERS = ["ticks", "worst_tick_cycles", "mean_tick_cycles", "deadline_cycles", "overruns", "late_ticks",
  "limited_ticks", "bridged_samples", "resets", "bus_frames", "bus_damaged", "bus_refused"];
const id = name => document.getElementById(name);
const make = (name, attributes, text) => {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const key in attributes) element.setAttribute(key, attributes[key]);
  if (text !== undefined) element.textContent = text;
  return element;
};
const html = (name, text) => Object.assign(document.createElement(name), { textContent: text });

let rows = [], isDue = false;

// Round numbers between two ends, about five of them.
const ticks = (low, high) => {
  const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find(factor => factor * power >= rough) * power, found = [];
  for (let at = Math.ceil(low / step) * step; at <= high + 1e-9 * step; at += step) found.push(at);
  return { found, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
};
// The ends of values, with some air; not too close together.
const ends = (values, least) => {
  let low = Infinity, high = -Infinity;
  for (const value of values) if (value !== null) { low = Math.min(low, value); high = Math.max(high, value); }
  if (low > high) [low, high] = [0, 0];
  const air = Math.max(0.05 * (high - low), (least - (high - low)) / 2);
  return [low - air, high + air];
};

const draw = (name, xs, lines, leastX, leastY, endsX) => {
  const plot = id(name), [x0, x1] = endsX ?? ends(xs, leastX), [y0, y1] = ends(lines.flat(), leastY);
  const across = x => SIZE.left + SIZE.width * (x - x0) / (x1 - x0);
  const down = y => SIZE.top + SIZE.height * (y1 - y) / (y1 - y0);
  const grid = [], numbers = [], bottom = SIZE.top + SIZE.height, right = SIZE.left + SIZE.width;
  const [xTicks, yTicks] = [ticks(x0, x1), ticks(y0, y1)];
  for (const at of xTicks.found) {
    grid.push(make("line", { x1: across(at), x2: across(at), y1: SIZE.top, y2: bottom }));
    numbers.push(make("text", { x: across(at), y: bottom + 22, "text-anchor": "middle" }, at.toFixed(xTicks.digits)));
  }
  for (const at of yTicks.found) {
    grid.push(make("line", { x1: SIZE.left, x2: right, y1: down(at), y2: down(at) }));
    numbers.push(make("text", { x: SIZE.left - 6, y: down(at) + 7, "text-anchor": "end" }, at.toFixed(yTicks.digits)));
  }
  plot.querySelector(".grid").replaceChildren(...grid);
  plot.querySelector(".numbers").replaceChildren(...numbers);
  plot.querySelectorAll("polyline").forEach((line, i) => line.setAttribute("points", lines[i]
    .map((y, row) => y === null ? "" : `${across(xs[row]).toFixed(1)},${down(y).toFixed(1)}`).join(" ")));
};

const show = () => {
  isDue = false;
  if (!rows.length) return;
  const column = index => rows.map(row => row[index]);
  const [time, wanted, contraction, pressure, command] = [0, 1, 2, 3, 4].map(column);
  const last = rows[rows.length - 1], window = [rows[0][0], Math.max(rows[0][0] + LEAST_SPAN_S, last[0])];
  draw("contraction", time, [contraction, wanted], 1, 1, window);
  draw("pressure", time, [pressure, command], 1, 0.2, window);
  draw("loop", pressure, [contraction], 0.2, 1);
  draw("error", time, [rows.map(row => row[1] === null ? null : row[2] - row[1])], 1, 1, window);
  id("now").textContent = `${last[2].toFixed(2)} mm, ${last[3].toFixed(2)} bar`;
};

const tell = status => {
  id("problem").hidden = !status.problem;
  id("problem").textContent = status.problem ?? "";
  if (status.problem) return;
  const state = id("state");
  state.textContent = status.state;
  state.className = ["Tracking", "Holding", "Service"].includes(status.state) ? "driven" : status.fault ? "fault" : "";
  id("acknowledge").disabled = !status.fault;
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
  const begin = rows.length ? rows[rows.length - 1][0] - SPAN_S : 0;
  rows = rows.filter(row => row[0] >= begin);
  if (news.status) tell(news.status);
  if (!isDue) { isDue = true; requestAnimationFrame(show); }
};
events.onerror = () => tell({ problem: "The program that serves this page has ended, or does not answer." });

const order = what => fetch(what, { method: "POST", headers: { "X-Mgpi-Order": "1" } })
  .then(answer => { if (!answer.ok) throw new Error(answer.statusText); })
  .catch(failure => tell({ problem: `The order was not heard: ${failure.message}` }));
id("stop").addEventListener("click", () => order("stop"));
id("acknowledge").addEventListener("click", () => order("acknowledge"));
