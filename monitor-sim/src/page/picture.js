// A picture over time: what it draws of a stretch of it, and what it reads at an instant.

const make = (name, parent, attributes) => {
  const element = document.createElementNS(parent.namespaceURI, name);
  for (const key in attributes) element.setAttribute(key, attributes[key]);
  return parent.appendChild(element);
};

// A curve of the plot, whose ordinate is y and whose values are shown by `shown`.
const curveOf = (path, y, shown) => {
  let pieces;
  const signal = () => pieces ??= decoded(path.dataset);
  return {
    path,
    drawn: path.getAttribute("d"),
    name: path.dataset.name,
    between: (a, b, x) => pathBetween(signal(), a, b, x, y),
    read(t) {
      const [piece, k] = nearest(signal(), t), least = piece.least(k), greatest = piece.greatest(k);
      if (t < piece.from - piece.step || t > signal()[0].to || Number.isNaN(least)) return "-";
      return shown(least) === shown(greatest) ? shown(least) : `${shown(least)} to ${shown(greatest)}`;
    },
  };
};

// A row of a logical output.
const rowOf = path => {
  const { name, spans, top, height } = path.dataset, times = spans ? spans.split(" ").map(Number) : [];
  const pairs = times.filter((_, k) => k % 2 === 0).map((from, k) => [from, times[2 * k + 1]]);
  return {
    path,
    drawn: path.getAttribute("d"),
    name,
    holds: t => pairs.some(([from, to]) => from <= t && t < to),
    between(a, b, x) {
      let d = "", end = -1;
      for (const [from, to] of pairs.filter(([from, to]) => to >= a && from <= b)) {
        // What is less than a pixel wide is as wide as one, and two of them in one are one.
        const start = Math.max(x(from), 0), stop = Math.min(Math.max(x(to), start + 1), x(b));
        if (stop > end) d += `M${start.toFixed(1)} ${top}h${(stop - start).toFixed(1)}v${height}H${start.toFixed(1)}z`;
        end = Math.max(end, stop);
      }
      return d;
    },
  };
};

const pictureOf = svg => {
  const plot = svg.querySelector(".plot"), field = plot.querySelector(".field");
  const ticks = svg.querySelector(".ticks"), drawnTicks = [...ticks.children], abscissa = svg.querySelector(".abscissa");
  const bands = [...plot.querySelectorAll(".band")];
  const labels = [...svg.querySelectorAll("text[data-from]")].map(text => ({ text, half: text.getComputedTextLength() / 2 }));
  const drawnView = svg.viewBox.baseVal.width, drawnWidth = plot.width.baseVal.value;
  const height = plot.height.baseVal.value, left = plot.x.baseVal.value, beside = drawnView - drawnWidth;
  let width = drawnWidth;

  // A logarithmic ordinate has a floor, which is as deep as its values are told.
  const { low, high, floor, name, unit } = plot.dataset;
  const power = value => (value > floor ? number(10 ** value) : `below ${number(10 ** floor)}`);
  const shown = floor === undefined ? number : power;
  const y = value => (height * Math.min(Math.max(1 - (value - low) / (high - low), 0), 1)).toFixed(1);
  const curves = [...plot.querySelectorAll(".curve")].map(path => curveOf(path, y, shown));
  const rows = [...plot.querySelectorAll("[data-spans]")].map(rowOf);
  const cross = make("path", plot, { class: "cross" });
  const picked = make("rect", plot, { class: "picked", height, width: 0 });

  const tick = (x, label) => {
    const copy = drawnTicks[0].cloneNode(true);
    copy.setAttribute("transform", `translate(${x.toFixed(1)})`);
    copy.querySelector("text").textContent = label;
    return copy;
  };
  const ticksBetween = (a, b, x) => {
    const rough = 80 * (b - a) / width, decade = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map(m => m * decade).find(s => s >= rough);
    const round = [];
    for (let k = Math.ceil(a / step); k * step <= b; k++) round.push(tick(x(k * step), String(+(k * step).toPrecision(10))));
    return round;
  };

  return {
    svg,
    width: () => width,
    // A window too narrow for the letters, which are then 80 % of their size, gets a narrower plot.
    fit(pixels) {
      const view = Math.max(beside + 100, Math.min(drawnView, pixels / 0.8));
      width = view - beside;
      svg.setAttribute("viewBox", `0 0 ${view} ${svg.viewBox.baseVal.height}`);
      plot.setAttribute("width", width);
      field.setAttribute("width", width);
      abscissa?.setAttribute("x", left + width / 2);
    },
    draw(a, b, all, x) {
      const whole = all && width === drawnWidth, inside = t => Math.min(Math.max(x(+t), 0), width);
      for (const part of [...curves, ...rows]) part.path.setAttribute("d", whole ? part.drawn : part.between(a, b, x));
      for (const band of bands) {
        band.setAttribute("x", inside(band.dataset.from));
        band.setAttribute("width", inside(band.dataset.to) - inside(band.dataset.from));
      }
      let named = 0;
      for (const { text, half } of labels) {
        const from = inside(text.dataset.from), to = inside(text.dataset.to);
        const middle = Math.max(Math.min(left + (from + to) / 2, beside + width - half), half);
        const room = from < to && middle - half >= named;
        text.setAttribute("x", middle);
        text.setAttribute("visibility", room ? "visible" : "hidden");
        if (room) named = middle + half + 8;
      }
      ticks.replaceChildren(...whole ? drawnTicks : ticksBetween(a, b, x));
    },
    mark(x) {
      cross.setAttribute("d", x === null ? "" : `M${x.toFixed(1)} 0v${height}`);
    },
    pick(from, to) {
      picked.setAttribute("x", Math.min(from, to));
      picked.setAttribute("width", Math.abs(to - from));
    },
    read(t) {
      const within = bands.filter(({ dataset: { from, to } }) => +from <= t && t < +to).map(band => band.dataset.name);
      const named = curve => (curves.length > 1 ? `${name} ${curve.name}` : name);
      const values = curves.map(curve => `${named(curve)} ${curve.read(t)}${unit && unit !== "1" ? " " + unit : ""}`);
      const stand = rows.filter(row => row.holds(t)).map(row => row.name);
      if (rows.length) values.push(stand.join(", ") || "nothing stands");
      return [...within, ...values];
    },
  };
};
