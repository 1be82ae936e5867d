// Zooms plots: drag over a part with a mouse or pen; keys + - and arrows; a double click or 0 shows all again.
for (const plot of document.querySelectorAll("svg.plot")) {
  const area = plot.querySelector(".lines");
  const [width, height] = ["width", "height"].map(name => Number(area.getAttribute(name)));
  const ends = { x: plot.dataset.x.split(" ").map(Number), y: plot.dataset.y.split(" ").map(Number) };
  const isLogarithm = "logarithm" in plot.dataset;
  const ticks = [...plot.querySelectorAll("[data-at]")];
  const labels = ticks.map(tick => tick.textContent);
  const whole = { x: 0, y: 0, width, height };
  let view = whole;

  const number = (value, span) => {
    if (isLogarithm) return (10 ** value).toPrecision(2);
    return value.toFixed(Math.min(9, Math.max(0, 2 - Math.floor(Math.log10(span)))));
  };
  const show = wanted => {
    const w = Math.min(width, Math.max(width / 500, wanted.width));
    const h = Math.min(height, Math.max(height / 500, wanted.height));
    const x = Math.min(width - w, Math.max(0, wanted.x)), y = Math.min(height - h, Math.max(0, wanted.y));
    view = { x, y, width: w, height: h };
    area.setAttribute("viewBox", `${x} ${y} ${w} ${h}`);
    const isWhole = w === width && h === height;
    plot.querySelector(".names").style.display = isWhole ? "" : "none";
    ticks.forEach((tick, i) => {
      const along = tick.parentNode.classList.contains("x") ? "x" : "y";
      const at = Number(tick.dataset.at), [low, high] = ends[along];
      const share = along === "x" ? (x + at * w) / width : 1 - (y + (1 - at) * h) / height;
      const span = (high - low) * (along === "x" ? w / width : h / height);
      tick.textContent = isWhole ? labels[i] : number(low + share * (high - low), span);
    });
  };
  // A place on the screen in the lines' own drawing.
  const place = event => {
    const box = area.getBoundingClientRect(), frame = plot.getBoundingClientRect();
    const scale = frame.width / plot.viewBox.baseVal.width;
    const left = frame.left + scale * area.getAttribute("x"), top = frame.top + scale * area.getAttribute("y");
    const clamp = share => Math.min(1, Math.max(0, share));
    return [
      view.x + clamp((event.clientX - left) / (scale * width)) * view.width,
      view.y + clamp((event.clientY - top) / (scale * height)) * view.height,
    ];
  };
  let from = null, frame = null;
  plot.addEventListener("pointerdown", event => {
    if (event.pointerType === "touch" || event.button !== 0) return;
    from = place(event);
    frame = document.createElementNS("http://www.w3.org/2000/svg", "rect");
    frame.setAttribute("class", "frame");
    area.append(frame);
    plot.setPointerCapture(event.pointerId);
    event.preventDefault();
  });
  const dragged = event => {
    const to = place(event);
    return {
      x: Math.min(from[0], to[0]), y: Math.min(from[1], to[1]),
      width: Math.abs(to[0] - from[0]), height: Math.abs(to[1] - from[1]),
    };
  };
  plot.addEventListener("pointermove", event => {
    if (from) for (const [name, value] of Object.entries(dragged(event))) frame.setAttribute(name, value);
  });
  plot.addEventListener("pointerup", event => {
    if (!from) return;
    const wanted = dragged(event);
    frame.remove();
    from = null;
    if (wanted.width > 0.01 * view.width && wanted.height > 0.01 * view.height) show(wanted);
  });
  plot.addEventListener("dblclick", () => show(whole));
  plot.addEventListener("keydown", event => {
    const about = factor => ({
      x: view.x + 0.5 * (1 - factor) * view.width, y: view.y + 0.5 * (1 - factor) * view.height,
      width: factor * view.width, height: factor * view.height,
    });
    const by = (x, y) => ({ ...view, x: view.x + x * view.width, y: view.y + y * view.height });
    const wanted = {
      "+": () => about(0.5), "-": () => about(2), 0: () => whole,
      ArrowLeft: () => by(-0.25, 0), ArrowRight: () => by(0.25, 0),
      ArrowUp: () => by(0, -0.25), ArrowDown: () => by(0, 0.25),
    }[event.key];
    if (!wanted || event.ctrlKey || event.metaKey || (view.width === width && event.key.startsWith("Arrow"))) return;
    event.preventDefault();
    show(wanted());
  });
}
