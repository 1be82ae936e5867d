// Shows what the stream of events brings: all boards, as they were last seen.
"use strict";
const id = name => document.getElementById(name);
const element = (name, text, className) => Object.assign(document.createElement(name), { textContent: text ?? "", className: className ?? "" });
const DRIVEN = ["Tracking", "Holding", "Service"];
// An answer that is older is told: the eye takes a standing number for a live one. Unit: s.
const OLD_S = 0.5;

const order = path => fetch(path, { method: "POST", headers: { "X-Mgpi-Order": "1" } });
id("stop").addEventListener("click", () => order("stop"));

const cards = new Map();
// A board's card, made once: a button that is replaced under the finger takes no click.
const cardOf = board => {
  if (cards.has(board.index)) return cards.get(board.index);
  const root = element("section", "", "board"), list = element("dl"), wrong = element("p", "", "wrong");
  const acknowledge = element("button", "Acknowledge"), state = element("span", "", "state"), values = {};
  const title = element("h2", `${board.name} `);
  title.append(element("small", `${board.line}, number ${board.number}`));
  for (const [name, words] of [["contraction", "contraction"], ["reference", "reference, error"], ["pressure", "pressure"],
    ["command", "command"], ["tick", "worst tick"], ["bus", "bus"], ["clock", "clock"]]) {
    values[name] = element("dd");
    list.append(element("dt", words), values[name]);
  }
  acknowledge.addEventListener("click", () => order(`acknowledge/${board.index}`));
  root.append(title, state, list, wrong, acknowledge);
  id("boards").append(root);
  const card = { root, state, list, values, wrong, acknowledge };
  cards.set(board.index, card);
  return card;
};

const show = ({ now_s, boards }) => {
  let seen = 0, driven = 0, faults = 0;
  const there = new Set(boards.map(board => board.index));
  for (const [index, card] of cards) if (!there.has(index)) { card.root.remove(); cards.delete(index); }
  boards.forEach(board => {
    const card = cardOf(board), told = board.telemetry, age_s = told && now_s - told.time_s;
    const isSeen = told && !board.problem, isDriven = isSeen && DRIVEN.includes(told.state), isFault = isSeen && told.fault !== 0;
    seen += isSeen ? 1 : 0; driven += isDriven ? 1 : 0; faults += isFault ? 1 : 0;
    card.root.className = `board ${isFault ? "fault" : isDriven ? "driven" : isSeen ? "" : "unseen"}`;
    const old = isSeen && age_s > OLD_S ? `, ${age_s.toFixed(1)} s ago` : "";
    card.state.textContent = isSeen ? told.state + old : told ? `not seen for ${age_s.toFixed(0)} s` : "not seen so far";
    card.acknowledge.hidden = !isFault;
    const fault = board.fault;
    card.wrong.hidden = !isFault && !board.problem;
    card.wrong.textContent = board.problem ? board.problem
      : isFault ? fault ? `Fault ${told.fault}, ${fault.title}. Cause: ${fault.cause}. Cure: ${fault.cure}.` : `Fault ${told.fault}, which this program does not know.` : "";
    card.list.hidden = !told;
    if (!told) return;
    const { contraction, reference, pressure, command, tick, bus, clock } = card.values;
    contraction.textContent = `${told.contraction_mm.toFixed(2)} mm`;
    reference.textContent = told.reference_mm === null ? "none is tracked"
      : `${told.reference_mm.toFixed(2)} mm, ${(told.reference_mm - told.contraction_mm).toFixed(2)} mm`;
    pressure.textContent = `${told.pressure_bar.toFixed(3)} bar of ${told.supply_bar.toFixed(2)} bar`;
    command.textContent = `${told.command_bar.toFixed(3)} bar`;
    tick.textContent = told.deadline_cycles ? `${(100 * told.worst_tick_cycles / told.deadline_cycles).toFixed(0)} % of the deadline` : "ticks have no clock";
    bus.textContent = `${board.round_s ? (1 / board.round_s).toFixed(0) : "–"} rounds/s, ${board.lost} of ${board.answered + board.lost} lost`;
    clock.textContent = `±\u00a0${(1e3 * told.time_bound_s).toFixed(1)}\u00a0ms, gains ${told.drift_ppm.toFixed(0)}\u00a0±\u00a0${told.drift_bound_ppm.toFixed(0)}\u00a0ppm`;
  });
  id("summary").textContent = `${seen} of ${boards.length} boards seen, ${driven} driven, ${faults} at fault`;
};

const events = new EventSource("events");
events.onmessage = event => show(JSON.parse(event.data));
events.onerror = () => { id("summary").textContent = "the gateway does not answer"; };
