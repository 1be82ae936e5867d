// Plots that are enlarged, pointed at and exported; of reports and of the live page.
"use strict";
const LEAST_SHARE = 1 / 500, LEAST_DRAG = 6, LEAST_PINCH = 30, HEAD = 52;
const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
const element = (name, attributes, text) => {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const key in attributes) made.setAttribute(key, attributes[key]);
  if (text !== undefined) made.textContent = text;
  return made;
};

// Round values between two ends with their labels, as `axis.rs` has them.
const roundValues = (low, high, most) => {
  const least = (high - low) / most, ten = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 5, 10].map(digit => digit * ten).find(step => step >= least) ?? 10 * ten;
  const decimals = clamp(Math.ceil(-Math.log10(step)), 0, 12), found = [];
  for (let count = Math.ceil(low / step); count <= Math.floor(high / step); count++) {
    found.push([count * step, (count * step + 0).toFixed(decimals)]);
  }
  return found;
};
const logarithmicLabel = (digit, exponent) => {
  if (exponent >= -4 && exponent <= 5) return (digit * 10 ** exponent).toFixed(Math.max(0, -exponent));
  const power = `10${[...String(exponent)].map(letter => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(letter)]).join("")}`;
  return digit === 1 ? power : `${digit}·${power}`;
};
// The ends are decimal logarithms.
const logarithmicValues = (low, high, most) => {
  const of = digits => {
    const found = [];
    for (let exponent = Math.floor(low); exponent <= Math.ceil(high); exponent++) for (const digit of digits) {
      const value = digit * 10 ** exponent, at = Math.log10(value);
      if (at >= low && at <= high) found.push([value, logarithmicLabel(digit, exponent)]);
    }
    return found;
  };
  const close = of([1, 2, 5]), whole = of([1]), every = Math.ceil(whole.length / most);
  if (close.length < 3) return roundValues(10 ** low, 10 ** high, most);
  return close.length <= 10 ? close : whole.filter((_, i) => i % every === 0);
};

class Plot {
  static all = [];

  constructor(drawing) {
    this.drawing = drawing;
    this.area = drawing.querySelector(".lines");
    [this.left, this.top, this.width, this.height] =
      ["x", "y", "width", "height"].map(name => Number(this.area.getAttribute(name)));
    this.isLogarithm = "logarithm" in drawing.dataset;
    this.names = { x: drawing.dataset.xName, y: drawing.dataset.yName };
    this.most = drawing.dataset.ticks.split(" ").map(Number);
    this.whole = { x: drawing.dataset.x.split(" ").map(Number), y: drawing.dataset.y.split(" ").map(Number) };
    this.view = this.whole;
    this.groups = [...this.area.querySelectorAll("g")];
    this.cursor = element("g", { class: "cursor" });
    drawing.append(this.cursor);
    this.fingers = new Map();
    this.addTools();
    this.listen();
    Plot.all.push(this);
  }

  get isWhole() { return ["x", "y"].every(axis => this.view[axis].every((end, i) => end === this.whole[axis][i])); }
  get others() {
    const { clock } = this.drawing.dataset;
    return clock ? Plot.all.filter(plot => plot !== this && plot.drawing.dataset.clock === clock) : [];
  }

  // What is drawn: each named line (any line where none has a name) as its pieces of [x, y] on the axes.
  get lines() {
    const places = line => Array.from(line.points, ({ x, y }) => this.onAxes(x, y));
    const isNamed = this.groups.some(group => group.dataset.name);
    this.read ??= this.groups.filter(group => group.dataset.name || !isNamed).map(group => ({
      name: group.dataset.name || this.names.y.replace(/ *\([^)]*\)$/, ""), colour: group.getAttribute("stroke"),
      pieces: [...group.children].map(places).filter(piece => piece.length),
    })).filter(line => line.pieces.length);
    return this.read;
  }
  // Whether every line only goes to the right, and none straight up, so that it has one value at a place.
  get isFunction() {
    this.rises ??= this.lines.every(({ pieces }) =>
      pieces.flat().every(([x], i, all) => i === 0 || all[i - 1][0] <= x)
      && pieces.every(piece => piece.length === 1 || piece[0][0] < piece[piece.length - 1][0]));
    return this.rises;
  }
  onAxes(x, y) {
    const [left, right] = this.whole.x, [low, high] = this.whole.y;
    return [left + x / this.width * (right - left), high - y / this.height * (high - low)];
  }
  isSeen(at) { return ["x", "y"].every((axis, i) => at[i] >= this.view[axis][0] && at[i] <= this.view[axis][1]); }
  across(x) { return this.left + this.width * (x - this.view.x[0]) / (this.view.x[1] - this.view.x[0]); }
  down(y) { return this.top + this.height * (this.view.y[1] - y) / (this.view.y[1] - this.view.y[0]); }
  value(at) { return this.isLogarithm ? 10 ** at : at; }
  text(at, axis) {
    if (this.isLogarithm) return this.value(at).toPrecision(3);
    const [low, high] = this.whole[axis];
    return (at + 0).toFixed(clamp(3 - Math.floor(Math.log10(high - low)), 0, 12));
  }

  // New lines, each as x and y of its points (a null interrupts it), between these ends; a part that is looked at stays.
  set(ends, lines) {
    const wasWhole = this.isWhole;
    [this.whole, this.read, this.rises] = [ends, undefined, undefined];
    const across = x => (this.width * (x - ends.x[0]) / (ends.x[1] - ends.x[0])).toFixed(2);
    const down = y => (this.height * (ends.y[1] - y) / (ends.y[1] - ends.y[0])).toFixed(2);
    lines.forEach(({ x, y }, i) => {
      const pieces = [[]];
      y.forEach((at, row) => at === null ? pieces.push([]) : pieces[pieces.length - 1].push(`${across(x[row])},${down(at)}`));
      const drawn = pieces.filter(piece => piece.length).map(piece => element("polyline", { points: piece.join(" ") }));
      this.groups[i].replaceChildren(...drawn);
    });
    this.show(wasWhole ? this.whole : this.view);
  }

  // Shows a part, and the same time in the plots of the same clock.
  show(wanted) {
    this.see(wanted);
    for (const other of this.others) other.see({ ...other.view, x: this.isWhole ? other.whole.x : this.view.x });
  }
  see(wanted) {
    const within = axis => {
      const [low, high] = this.whole[axis], [from, to] = wanted[axis];
      const span = clamp(to - from, LEAST_SHARE * (high - low), high - low), begin = clamp(from, low, high - span);
      return span === high - low ? [low, high] : [begin, begin + span];
    };
    this.view = { x: within("x"), y: within("y") };
    const share = (at, [low, high]) => (at - low) / (high - low);
    const x = [0, 1].map(i => this.width * share(this.view.x[i], this.whole.x));
    const y = [1, 0].map(i => this.height * (1 - share(this.view.y[i], this.whole.y)));
    this.area.setAttribute("viewBox", `${x[0]} ${y[0]} ${x[1] - x[0]} ${y[1] - y[0]}`);
    this.drawing.querySelector(".names").style.display = this.isWhole ? "" : "none";
    this.drawing.classList.toggle("enlarged", !this.isWhole);
    this.all.disabled = this.isWhole;
    this.drawTicks();
    if (this.at) this.readout.textContent = this.mark(this.at) ?? "";
  }
  drawTicks() {
    const [x, y] = ["x", "y"].map((axis, i) => {
      const [low, high] = this.view[axis];
      const values = (this.isLogarithm ? logarithmicValues : roundValues)(low, high, this.most[i]);
      return values.map(([value, label]) => [this.isLogarithm ? Math.log10(value) : value, label]);
    });
    const [right, bottom] = [this.left + this.width, this.top + this.height];
    const ink = this.drawing.querySelector(".x").dataset.grid;
    const pair = (line, text, label) => [element("line", { ...line, stroke: ink }), element("text", text, label)];
    this.drawing.querySelector(".x").replaceChildren(...x.flatMap(([at, label]) => {
      const place = this.across(at).toFixed(1);
      return pair({ x1: place, x2: place, y1: this.top, y2: bottom }, { x: place, y: bottom + 22 }, label);
    }));
    this.drawing.querySelector(".y").replaceChildren(...y.flatMap(([at, label]) => {
      const place = this.down(at).toFixed(1);
      return pair({ x1: this.left, x2: right, y1: place, y2: place }, { x: this.left - 8, y: Number(place) + 6 }, label);
    }));
  }

  // Marks the values at a place of the axes, and says them; at null nothing.
  point(at) {
    const said = this.mark(at);
    this.readout.textContent = said ?? "";
    for (const other of this.others) other.readout.textContent = (at && other.mark(at)) ?? "";
  }
  mark(at) {
    this.at = at;
    this.cursor.replaceChildren();
    if (!at || !this.lines.length) return null;
    const named = (axis, place) => {
      const unit = /\(([^)]*)\)$/.exec(this.names[axis])?.[1] ?? "";
      return `${this.text(place, axis)} ${unit}`.trim();
    };
    const x = this.names.x.replace(/ *\([^)]*\)$/, "");
    const found = this.isFunction ? this.valuesAt(at[0]) : this.nearest(at);
    const place = this.isFunction ? at[0] : found[0]?.at[0];
    if (!found.length || place < this.view.x[0] || place > this.view.x[1]) return null;
    const across = this.across(place);
    this.cursor.append(element("line", { x1: across, x2: across, y1: this.top, y2: this.top + this.height }));
    for (const { at, colour } of found) if (this.isSeen(at)) {
      this.cursor.append(element("circle", { cx: this.across(at[0]), cy: this.down(at[1]), r: 5, fill: colour }));
    }
    return [`${x} ${named("x", place)}`, ...found.map(({ name, at }) => `${name} ${named("y", at[1])}`)].join(" · ");
  }
  valuesAt(x) {
    return this.lines.flatMap(({ name, colour, pieces }) => {
      const piece = pieces.find(piece => piece[0][0] <= x && x <= piece[piece.length - 1][0]);
      if (!piece) return [];
      const after = Math.max(1, piece.findIndex(point => point[0] >= x));
      const [from, to] = [piece[after - 1], piece[after] ?? piece[after - 1]];
      const share = to[0] > from[0] ? (x - from[0]) / (to[0] - from[0]) : 0;
      return [{ name, colour, at: [x, from[1] + share * (to[1] - from[1])] }];
    });
  }
  nearest([x, y]) {
    let best = null, least = Infinity;
    for (const { name, colour, pieces } of this.lines) for (const at of pieces.flat()) if (this.isSeen(at)) {
      const distance = Math.hypot(this.across(at[0]) - this.across(x), this.down(at[1]) - this.down(y));
      if (distance < least) [least, best] = [distance, { name, colour, at }];
    }
    return best ? [best] : [];
  }

  // Where the pointer is: in shares of the area, and on the axes.
  shares(event) {
    const frame = this.drawing.getBoundingClientRect(), scale = frame.width / this.drawing.viewBox.baseVal.width;
    return [(event.clientX - frame.left - scale * this.left) / (scale * this.width),
      1 - (event.clientY - frame.top - scale * this.top) / (scale * this.height)].map(share => clamp(share, 0, 1));
  }
  axesAt(shares, view = this.view) {
    return ["x", "y"].map((axis, i) => view[axis][0] + shares[i] * (view[axis][1] - view[axis][0]));
  }
  about(factor, at = this.axesAt([0.5, 0.5])) {
    const around = (axis, i) => this.view[axis].map(end => at[i] + factor * (end - at[i]));
    return { x: around("x", 0), y: around("y", 1) };
  }
  moved(x, y) {
    const by = (axis, share) => this.view[axis].map(end => end + share * (this.view[axis][1] - this.view[axis][0]));
    return { x: by("x", x), y: by("y", y) };
  }

  listen() {
    const on = (kind, act) => this.drawing.addEventListener(kind, act);
    on("pointerdown", event => {
      if (event.button !== 0) return;
      this.fingers.set(event.pointerId, this.shares(event));
      this.from = { view: this.view, fingers: new Map(this.fingers), event };
      if (event.pointerType !== "touch") this.drawing.setPointerCapture(event.pointerId);
      this.point(this.axesAt(this.shares(event)));
    });
    on("pointermove", event => {
      if (!this.fingers.has(event.pointerId)) { this.point(this.axesAt(this.shares(event))); return; }
      this.fingers.set(event.pointerId, this.shares(event));
      if (this.fingers.size > 1) this.pinch();
      else if (event.pointerType === "touch") this.dragFinger(event);
      else this.drawFrame(event);
    });
    const end = event => {
      const isDrag = this.fingers.delete(event.pointerId) && event.pointerType !== "touch" && event.type === "pointerup";
      this.frame?.remove();
      if (isDrag && this.frame) this.show(this.framed(event));
      this.frame = null;
      this.from = { view: this.view, fingers: new Map(this.fingers), event };
    };
    on("pointerup", end);
    on("pointercancel", end);
    on("pointerleave", event => { if (event.pointerType === "mouse" && !this.fingers.size) this.point(null); });
    on("dblclick", () => this.show(this.whole));
    on("wheel", event => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      this.show(this.about(1.01 ** clamp(event.deltaY, -50, 50), this.axesAt(this.shares(event))));
    });
    on("keydown", event => this.press(event));
  }
  // What the pointer is drawn over; along an axis that it hardly moved along, all that is seen.
  isDragged(event, name) { return Math.abs(event[name] - this.from.event[name]) >= LEAST_DRAG; }
  framed(event) {
    const [one, other] = [this.axesAt([...this.from.fingers.values()][0]), this.axesAt(this.shares(event))];
    const ends = (axis, i, name) => this.isDragged(event, name)
      ? [Math.min(one[i], other[i]), Math.max(one[i], other[i])] : this.view[axis];
    return { x: ends("x", 0, "clientX"), y: ends("y", 1, "clientY") };
  }
  drawFrame(event) {
    if (!this.frame && !this.isDragged(event, "clientX") && !this.isDragged(event, "clientY")) return;
    if (!this.frame) this.drawing.append(this.frame = element("rect", { class: "frame" }));
    const { x: [left, right], y: [low, high] } = this.framed(event);
    const place = { x: this.across(left), y: this.down(high), width: this.across(right) - this.across(left),
      height: this.down(low) - this.down(high) };
    for (const name in place) this.frame.setAttribute(name, place[name]);
  }
  // One finger moves the part that is seen, or points where all is.
  dragFinger(event) {
    const to = this.shares(event);
    if (this.isWhole) { this.point(this.axesAt(to)); return; }
    const from = this.from.fingers.get(event.pointerId), { view } = this.from;
    const by = (axis, i) => view[axis].map(end => end - (to[i] - from[i]) * (view[axis][1] - view[axis][0]));
    this.show({ x: by("x", 0), y: by("y", 1) });
  }
  // What two fingers took hold of stays below them.
  pinch() {
    const ids = [...this.fingers.keys()].slice(0, 2), { view } = this.from;
    const [a, b] = ids.map(id => this.from.fingers.get(id)), [c, d] = ids.map(id => this.fingers.get(id));
    if (!a || !b) return;
    const size = [this.width, this.height];
    const apart = (one, other) => Math.hypot(...size.map((length, i) => length * (one[i] - other[i])));
    const grown = apart(a, b) / Math.max(1, apart(c, d));
    const stretched = i => Math.min(Math.abs(a[i] - b[i]), Math.abs(c[i] - d[i])) * size[i] > LEAST_PINCH
      ? Math.abs(a[i] - b[i]) / Math.abs(c[i] - d[i]) : grown;
    const ends = (axis, i) => {
      const [low, high] = view[axis], held = low + (a[i] + b[i]) / 2 * (high - low), span = stretched(i) * (high - low);
      const begin = held - (c[i] + d[i]) / 2 * span;
      return [begin, begin + span];
    };
    this.show({ x: ends("x", 0), y: ends("y", 1) });
  }
  press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = by => {
      const [low, high] = this.view.x, at = this.at ?? this.axesAt([0.5, 0.5]);
      this.point([clamp(at[0] + by * (high - low) / 50, low, high), at[1]]);
    };
    const act = (event.shiftKey ? {
      ArrowLeft: () => this.show(this.moved(-0.25, 0)), ArrowRight: () => this.show(this.moved(0.25, 0)),
      ArrowUp: () => this.show(this.moved(0, 0.25)), ArrowDown: () => this.show(this.moved(0, -0.25)),
      "+": () => this.show(this.about(0.5)),
    } : {
      "+": () => this.show(this.about(0.5)), "-": () => this.show(this.about(2)), 0: () => this.show(this.whole),
      ArrowLeft: () => step(-1), ArrowRight: () => step(1), Escape: () => this.point(null),
    })[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }

  addTools() {
    const tools = Object.assign(document.createElement("div"), { className: "tools" });
    const button = (label, title, act) => {
      const made = Object.assign(document.createElement("button"), { type: "button", textContent: label, title });
      made.setAttribute("aria-label", `${title}: ${this.title}`);
      made.addEventListener("click", act);
      tools.append(made);
      return made;
    };
    this.all = button("all", "Show all of the plot", () => this.show(this.whole));
    this.all.disabled = true;
    button("SVG", "Save the plot as SVG", () => this.save("svg", new Blob([this.picture()], { type: "image/svg+xml" })));
    button("PNG", "Save the plot as PNG", () => this.savePng());
    button("CSV", "Save the points that are drawn, as CSV", () => this.save("csv", new Blob([this.table()], { type: "text/csv" })));
    this.readout = Object.assign(document.createElement("p"), { className: "readout" });
    this.readout.setAttribute("role", "status");
    this.drawing.after(this.readout, tools);
  }
  get title() { return this.drawing.closest("figure").querySelector("figcaption").firstChild.textContent.trim(); }
  save(end, content) {
    const words = this.title.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-+|-+$/g, "");
    saveFile(`${words}${end === "csv" ? "-as-drawn" : ""}.${end}`, content);
  }
  // The plot as a file of its own, in the colours of paper, with its title and legend.
  picture() {
    const { width, height } = this.drawing.viewBox.baseVal, inside = this.drawing.cloneNode(true);
    inside.querySelectorAll(".cursor, .frame").forEach(part => part.remove());
    for (const name in inside.dataset) delete inside.dataset[name];
    for (const name of ["class", "tabindex"]) inside.removeAttribute(name);
    for (const [name, value] of Object.entries({ y: HEAD, width, height })) inside.setAttribute(name, value);
    const all = element("svg", { viewBox: `0 0 ${width} ${height + HEAD}`, width, height: height + HEAD });
    all.append(element("style", {}, `${document.querySelector("[data-dashes]").dataset.dashes}
      polyline{vector-effect:non-scaling-stroke} text{font-family:sans-serif}`));
    all.append(element("rect", { width, height: height + HEAD, fill: "#fff" }));
    const ink = { fill: "#333", "font-size": 16 };
    all.append(element("text", { ...ink, x: width / 2, y: 20, "text-anchor": "middle", "font-weight": 600 }, this.title));
    let left = this.left;
    for (const key of this.drawing.closest("figure").querySelectorAll(".legend > span")) {
      const stroke = key.querySelector("line").cloneNode(), entry = element("g", { transform: `translate(${left},36)` });
      entry.append(stroke, element("text", { ...ink, x: 42, y: 10 }, key.textContent));
      all.append(entry);
      left += 66 + 8 * key.textContent.length;
    }
    all.append(inside);
    return new XMLSerializer().serializeToString(all);
  }
  savePng() {
    const picture = new Image();
    picture.onload = () => {
      const canvas = document.createElement("canvas");
      [canvas.width, canvas.height] = [2 * picture.width, 2 * picture.height];
      canvas.getContext("2d").drawImage(picture, 0, 0, canvas.width, canvas.height);
      canvas.toBlob(content => this.save("png", content));
    };
    picture.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(this.picture())}`;
  }
  // A row a point, with the line and the piece of it that the point belongs to.
  table() {
    const quoted = text => `"${text.replaceAll('"', '""')}"`;
    const rows = this.lines.flatMap(({ name, pieces }) => pieces.flatMap((piece, i) => piece.map(([x, y]) =>
      [quoted(name), i + 1, ...[x, y].map(at => Number(this.value(at).toPrecision(6)))].join(","))));
    return [["line", "piece", quoted(this.names.x), quoted(this.names.y)].join(","), ...rows, ""].join("\n");
  }
}

const saveFile = (name, content) => {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(content), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
};

for (const drawing of document.querySelectorAll("svg.plot")) new Plot(drawing);
