// One view [a, b] in seconds for all pictures over the same time as the first. Without this script the page stands as drawn.
(() => {
  const pictures = [...document.querySelectorAll("svg[data-time]")].filter((svg, _, all) => svg.dataset.time === all[0].dataset.time);
  if (!pictures.length) return;
  const NS = pictures[0].namespaceURI;
  const LEFT = 130, RIGHT = 982, TOP = 24, SPAN = RIGHT - LEFT;
  const [first, last] = pictures[0].dataset.time.split(" ").map(Number);
  let a = first, b = last;
  const make = (name, attributes, parent) => {
    const element = document.createElementNS(NS, name);
    for (const key in attributes) element.setAttribute(key, attributes[key]);
    return parent.appendChild(element);
  };
  const plots = pictures.map((svg, k) => {
    const bottom = svg.viewBox.baseVal.height - Number(svg.dataset.bottom);
    const clip = make("clipPath", { id: "plot" + k }, svg);
    make("rect", { x: LEFT, y: 0, width: SPAN, height: bottom }, clip);
    const window = make("g", { "clip-path": `url(#plot${k})` }, svg), curves = make("g", {}, window);
    const labels = [], ticks = [], marks = make("g", {}, svg);
    for (const e of [...svg.children]) {
      if (e === window || e === marks || e === clip || !e.getBBox) continue;
      const box = e.getBBox(), colour = [e.getAttribute("stroke"), e.getAttribute("fill")].find(c => c && c !== "none");
      // Curves, intervals and bands move with the view; axes, grid and limits stay.
      if (e.tagName !== "text" && /^#(0[BCDE]|030303)/.test(colour)) { e.style.vectorEffect = "non-scaling-stroke"; curves.append(e); }
      else if (e.tagName === "text" && box.y > bottom && e.textContent.trim() !== "time, s") ticks.push(e);
      else if (e.tagName === "polyline" && box.y >= bottom && box.height < 8 && box.width < 1) ticks.push(e);
      else if (e.tagName === "text" && box.y + box.height / 2 < TOP && box.x > LEFT) { labels.push([e, +e.getAttribute("x")]); window.append(e); }
    }
    return { curves, labels, ticks, marks, bottom };
  });
  const x = t => LEFT + SPAN * (t - a) / (b - a);
  const draw = () => {
    const whole = a === first && b === last, scale = (last - first) / (b - a);
    const rough = (b - a) / 8, decade = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map(m => m * decade).find(s => s >= rough);
    for (const p of plots) {
      p.curves.setAttribute("transform", `translate(${x(first) - scale * LEFT} 0) scale(${scale} 1)`);
      p.labels.forEach(([e, at]) => e.setAttribute("x", x(first + (at - LEFT) / SPAN * (last - first))));
      p.ticks.forEach(e => { e.style.display = whole ? "" : "none"; });
      p.marks.replaceChildren();
      for (let k = Math.ceil(a / step); !whole && k * step <= b; k++) {
        const at = x(k * step);
        make("line", { x1: at, x2: at, y1: p.bottom, y2: p.bottom + 5, stroke: "#010101" }, p.marks);
        make("text", { x: at, y: p.bottom + 18, "text-anchor": "middle", "font-size": 11, fill: "#010101" }, p.marks).textContent = +(k * step).toPrecision(8);
      }
    }
    document.documentElement.dataset.view = `${a}..${b}`;
  };
  const show = (from, to) => {
    const width = Math.min(last - first, Math.max(to - from, (last - first) / 5000));
    a = Math.min(Math.max(from, first), last - width); b = a + width;
    draw();
  };
  const zoom = (by, at) => show(at - (at - a) * by, at + (b - at) * by);
  pictures.forEach(svg => {
    const time = e => { const r = svg.getBoundingClientRect(); return a + ((e.clientX - r.left) / r.width * 1000 - LEFT) / SPAN * (b - a); };
    let from = null;
    svg.addEventListener("wheel", e => { if (e.ctrlKey || e.shiftKey) { e.preventDefault(); zoom((e.deltaY || e.deltaX) > 0 ? 1.25 : 0.8, time(e)); } }, { passive: false });
    svg.addEventListener("pointerdown", e => { if (e.pointerType === "mouse") from = time(e); });
    svg.addEventListener("pointerup", e => {
      const to = time(e);
      if (from !== null && Math.abs(to - from) > (b - a) / 100) show(Math.min(from, to), Math.max(from, to));
      from = null;
    });
    svg.addEventListener("dblclick", () => show(first, last));
  });
  new Set(pictures.map(svg => svg.parentElement)).forEach(figure => figure.addEventListener("keydown", e => {
    const middle = (a + b) / 2, pan = (b - a) / 5;
    const act = { "+": () => zoom(0.5, middle), "-": () => zoom(2, middle), 0: () => show(first, last), Escape: () => show(first, last),
      ArrowLeft: () => show(a - pan, b - pan), ArrowRight: () => show(a + pan, b + pan) }[e.key];
    if (act && !e.ctrlKey && !e.metaKey) { e.preventDefault(); act(); }
  }));
  // The instants of a table of events are buttons that move the view there.
  const events = [...document.querySelectorAll("table")].filter(t => t.tHead.rows[0].cells[0].textContent === "at, s")
    .flatMap(t => [...t.tBodies[0].rows]).map(row => row.cells[0]);
  const visit = cell => {
    const t = parseFloat(cell.textContent);
    show(t - (last - first) / 70, t + (last - first) / 35);
    pictures[0].scrollIntoView({ block: "center", behavior: matchMedia("(prefers-reduced-motion: reduce)").matches ? "auto" : "smooth" });
  };
  for (const cell of events) {
    const button = document.createElement("button");
    button.textContent = cell.textContent;
    button.title = "show in the pictures";
    button.onclick = () => visit(cell);
    cell.replaceChildren(button);
  }
  addEventListener("beforeprint", () => show(first, last));
  // A link ending in #t=20..30 opens on that stretch, one in #event=2 at the second event.
  const linked = () => { const m = /^#t=([\d.]+?)\.\.([\d.]+)$/.exec(location.hash); if (m && +m[2] > +m[1]) show(+m[1], +m[2]);
    const event = /^#event=(\d+)$/.exec(location.hash); if (event && events[event[1] - 1]) visit(events[event[1] - 1]);
  };
  addEventListener("hashchange", linked);
  draw(); linked();
})();
