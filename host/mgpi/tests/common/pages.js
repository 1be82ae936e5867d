// Looks at the report in the frame, and writes what is wrong with it into #faults.
const frame = document.querySelector("iframe"), faults = [];
frame.addEventListener("load", () => {
  const { contentDocument: page, contentWindow: view } = frame;
  const named = element => `${element.tagName} "${element.textContent.trim().slice(0, 40)}"`;
  const width = page.documentElement.clientWidth;
  if (page.documentElement.scrollWidth > width) faults.push(`the page is wider than ${width} pixels`);

  // Cut: beyond the page, beyond the edge of a table that would have to be scrolled; letters beyond their drawing.
  const all = [...page.querySelectorAll("h1, h2, h3, p, li, dt, dd, figcaption, td, th, span, code, text")];
  const seen = all.filter(element => element.textContent.trim() && element.getClientRects().length);
  for (const element of seen) {
    const box = element.getBoundingClientRect();
    const drawing = element.closest("figure > svg"), around = element.closest(".wide");
    const bounds = (drawing ?? around ?? page.body).getBoundingClientRect();
    const isCut = box.left < bounds.left - 1 || box.right > bounds.right + 1
      || (drawing && (box.top < bounds.top - 1 || box.bottom > bounds.bottom + 1));
    if (isCut) faults.push(`cut: ${named(element)}`);
    const turn = element.closest("svg") && element.getScreenCTM();
    const scale = turn ? Math.hypot(turn.a, turn.b) : 1;
    const size = scale * parseFloat(view.getComputedStyle(element).fontSize);
    if (size < 9) faults.push(`letters of ${size.toFixed(1)} pixels: ${named(element)}`);
  }

  // One over another: letters of a drawing, blocks of the page.
  const overlap = (elements, what) => {
    const boxes = elements.map(element => [element, element.getBoundingClientRect()]);
    boxes.forEach(([one, a], i) => boxes.slice(i + 1).forEach(([other, b]) => {
      if (one.contains(other) || other.contains(one)) return;
      const x = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const y = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (x > 1 && y > 1) faults.push(`${what}: ${named(one)} and ${named(other)}`);
    }));
  };
  for (const drawing of page.querySelectorAll("figure > svg")) overlap([...drawing.querySelectorAll("text")], "over another");
  overlap([...page.querySelectorAll("h1, h2, h3, p, dl, ul, table, figure")].filter(e => !e.closest("figure ul")), "over another");

  // Every drawing has a name; a plot is enlarged by a key and comes back, says values, and can be saved.
  for (const drawing of page.querySelectorAll("[role=img]")) {
    if (!drawing.querySelector("title")?.textContent.trim()) faults.push("a drawing without a name");
  }
  for (const plot of page.querySelectorAll("svg.plot")) {
    const lines = plot.querySelector(".lines"), figure = plot.closest("figure");
    const labels = () => [...plot.querySelectorAll(".x text, .y text")].map(label => label.textContent).join();
    const before = [lines.getAttribute("viewBox"), labels()];
    const press = key => plot.dispatchEvent(new view.KeyboardEvent("keydown", { key }));
    press("+");
    if (lines.getAttribute("viewBox") === before[0] || labels() === before[1]) faults.push(`not enlarged: ${named(plot)}`);
    if (/\d{8}|e[+-]\d/.test(labels())) faults.push(`not round: ${labels()}`);
    press("0");
    if (labels() !== before[1]) faults.push(`other numbers than without a script: ${labels()} for ${before[1]}`);
    press("ArrowRight");
    const said = figure.querySelector(".readout").textContent;
    if (!/\d/.test(said)) faults.push(`says no value: ${named(plot)}`);
    press("Escape");
    const words = figure.querySelector(".tools").textContent;
    if (words !== "allSVGPNGCSV") faults.push(`tools of a plot: ${words}`);
  }
  for (const plot of view.eval("Plot.all")) {
    const picture = new DOMParser().parseFromString(plot.picture(), "image/svg+xml");
    if (picture.querySelector("parsererror") || !picture.querySelector("polyline")) faults.push(`no picture: ${plot.title}`);
    const [head, ...rows] = plot.table().trim().split("\n");
    if (!head.includes(plot.names.x) || !rows.length || rows.some(row => !/,-?[\d.e-]+,-?[\d.e-]+$/.test(row))) {
      faults.push(`no table: ${plot.title}`);
    }
  }
  document.getElementById("faults").textContent = [...(view.failures ?? ["no log of errors"]), ...faults].join("\n");
});
