// Pictures over the same time share one view of it, [a, b] in seconds, and a cross-hair. What is drawn, where, in which unit and
// by which scale is said by the pictures; without this script they stand as drawn.
(() => {
  const make = (name, parent, attributes = {}) => {
    const element = document.createElementNS(parent.namespaceURI, name);
    for (const key in attributes) element.setAttribute(key, attributes[key]);
    return parent.appendChild(element);
  };
  const readOut = make("output", document.body, { class: "read", hidden: "" });

  // Four digits, as the page's tables have them.
  const number = value => {
    const size = Math.abs(value);
    return value === 0 ? "0" : size >= 1e6 || size < 1e-5 ? value.toExponential(2) : String(+value.toPrecision(size >= 1000 ? 6 : 4));
  };

  // A signal's pieces: where each begins, how far apart its values are, and what they are, on the axis of its picture.
  const decoded = ({ low, span, pieces, codes }) => {
    const digit = at => codes.charCodeAt(at) - 63, gap = 2 ** 18 - 1;
    const value = n => {
      const code = digit(3 * n) << 12 | digit(3 * n + 1) << 6 | digit(3 * n + 2);
      return code === gap ? NaN : +low + span * code / (gap - 1);
    };
    let first = 0;
    return pieces.split(";").map(piece => {
      const [from, step, each, count] = piece.split(" ").map(Number), offset = first;
      first += each * count;
      return { from, step, count, to: from + step * count, each, least: k => value(offset + each * k), greatest: k => value(offset + each * (k + 1) - 1) };
    });
  };

  // The finest piece at t, and the index of its value there.
  const nearest = (pieces, t) => {
    const piece = pieces.findLast(p => p.from <= t && t < p.to) ?? pieces[0];
    const k = (t - piece.from) / piece.step;
    return [piece, Math.min(Math.max(piece.each > 1 ? Math.floor(k) : Math.round(k), 0), piece.count - 1)];
  };

  const picture = svg => {
    const plot = svg.querySelector(".plot"), field = plot.querySelector(".field");
    const drawnWidth = plot.width.baseVal.value, height = plot.height.baseVal.value, left = plot.x.baseVal.value;
    const drawnView = svg.viewBox.baseVal.width, beside = drawnView - drawnWidth;
    let width = drawnWidth;
    const { low, high, log, name, unit } = plot.dataset;
    const shown = value => number(log === undefined ? value : 10 ** value);
    const y = value => (height * Math.min(Math.max(1 - (value - low) / (high - low), 0), 1)).toFixed(1);

    const curves = [...plot.querySelectorAll(".curve")].map(path => {
      const drawn = path.getAttribute("d");
      let pieces;
      const signal = () => pieces ??= decoded(path.dataset);
      const between = (a, b, x) => {
        let d = "", at = a, pen = "M", column = null;
        // All values in a column of pixels are one stroke from the least to the greatest.
        const stroke = () => {
          if (!column) return;
          const [first, second] = column.last > (column.least + column.greatest) / 2 ? [column.greatest, column.least] : [column.least, column.greatest];
          d += pen + column.from.toFixed(1) + " " + y(first);
          if (first !== second) d += "L" + column.to.toFixed(1) + " " + y(second);
          pen = "L";
        };
        const take = (from, to, least, greatest) => {
          if (Number.isNaN(least)) { stroke(); column = null; pen = "M"; return; }
          if (column && from - column.start < 1) {
            column.to = to; column.least = Math.min(column.least, least); column.greatest = Math.max(column.greatest, greatest);
            return;
          }
          stroke();
          column = { start: from, from, to, least, greatest, last: column ? (column.least + column.greatest) / 2 : least };
        };
        const part = (piece, to) => {
          // One value more on either side, so that the line crosses the edges of the plot.
          const last = Math.min(Math.ceil((to - piece.from) / piece.step) + 1, piece.count);
          for (let k = Math.max(Math.floor((at - piece.from) / piece.step) - 1, 0); k < last; k++) {
            const t = piece.from + k * piece.step;
            if (t >= to && to < b) break;
            take(x(t), x(piece.each > 1 ? t + piece.step : t), piece.least(k), piece.greatest(k));
          }
          at = to;
        };
        const [whole, ...closeUps] = signal();
        for (const closeUp of closeUps.filter(p => p.from < b && p.to > a)) {
          if (closeUp.from > at) part(whole, closeUp.from);
          part(closeUp, Math.min(closeUp.to, b));
        }
        if (at < b) part(whole, b);
        stroke();
        return d;
      };
      const read = t => {
        const [piece, k] = nearest(signal(), t), least = piece.least(k), greatest = piece.greatest(k);
        if (!(t >= piece.from - piece.step && t <= signal()[0].to) || Number.isNaN(least)) return "-";
        return shown(least) === shown(greatest) ? shown(least) : shown(least) + " to " + shown(greatest);
      };
      return { path, drawn, name: path.dataset.name, read, between };
    });

    const rows = [...plot.querySelectorAll("[data-spans]")].map(path => {
      const { name, spans, top, height } = path.dataset, times = spans.split(" ").map(Number);
      const pairs = spans ? times.filter((_, k) => k % 2 === 0).map((from, k) => [from, times[2 * k + 1]]) : [];
      const between = (a, b, x) => {
        let d = "", end = -1;
        for (const [from, to] of pairs) {
          if (to < a || from > b) continue;
          // What is less than a pixel wide is as wide as one, and two of them in one are one.
          const start = Math.max(x(from), 0), stop = Math.min(Math.max(x(to), start + 1), width);
          if (stop > end) d += `M${start.toFixed(1)} ${top}h${(stop - start).toFixed(1)}v${height}H${start.toFixed(1)}z`;
          end = Math.max(end, stop);
        }
        return d;
      };
      return { path, drawn: path.getAttribute("d"), name, holds: t => pairs.some(([from, to]) => from <= t && t < to), between };
    });

    const bands = [...plot.querySelectorAll(".band")], labels = [...svg.querySelectorAll("text[data-from]")];
    const ticks = svg.querySelector(".ticks"), drawnTicks = [...ticks.children], abscissa = svg.querySelector(".abscissa");
    const cross = make("path", plot, { class: "cross" });
    const picked = make("rect", plot, { class: "picked", height, width: 0 });

    const tick = (x, label) => {
      const copy = drawnTicks[0].cloneNode(true);
      copy.setAttribute("transform", `translate(${x.toFixed(1)})`);
      copy.querySelector("text").textContent = label;
      return copy;
    };

    return {
      svg, field,
      width: () => width,
      // A window too narrow for the letters, which are then 80 % of their size, gets a narrower plot.
      fit(pixels) {
        const view = Math.min(drawnView, pixels / 0.8);
        width = view - beside;
        svg.setAttribute("viewBox", `0 0 ${view} ${svg.viewBox.baseVal.height}`);
        plot.setAttribute("width", width);
        field.setAttribute("width", width);
        abscissa?.setAttribute("x", left + width / 2);
      },
      draw(a, b, all, x) {
        const whole = all && width === drawnWidth;
        for (const part of [...curves, ...rows]) part.path.setAttribute("d", whole ? part.drawn : part.between(a, b, x));
        const ends = ({ from, to }) => [Math.min(Math.max(x(+from), 0), width), Math.min(Math.max(x(+to), 0), width)];
        for (const band of bands) {
          const [from, to] = ends(band.dataset);
          band.setAttribute("x", from);
          band.setAttribute("width", to - from);
        }
        for (const label of labels) {
          const [from, to] = ends(label.dataset);
          label.setAttribute("x", left + (from + to) / 2);
          label.style.display = from < to ? "" : "none";
        }
        const rough = 100 * (b - a) / width, decade = 10 ** Math.floor(Math.log10(rough));
        const step = [1, 2, 5, 10].map(m => m * decade).find(s => s >= rough);
        const round = [];
        for (let k = Math.ceil(a / step); k * step <= b; k++) round.push(tick(x(k * step), String(+(k * step).toPrecision(10))));
        ticks.replaceChildren(...whole ? drawnTicks : round);
      },
      mark(x) { cross.setAttribute("d", x === null ? "" : `M${x} 0v${height}`); },
      pick(from, to) { picked.setAttribute("x", Math.min(from, to)); picked.setAttribute("width", Math.abs(to - from)); },
      read(t) {
        const named = curve => (curves.length > 1 ? `${name} ${curve.name}` : name);
        const values = curves.map(curve => `${named(curve)} ${curve.read(t)}${unit && unit !== "1" ? " " + unit : ""}`);
        const stand = rows.filter(row => row.holds(t)).map(row => row.name);
        return rows.length ? [...values, stand.join(", ") || "nothing stands"] : values;
      },
    };
  };

  // Pictures over the same time.
  const axis = svgs => {
    const pictures = svgs.map(picture), { width } = pictures[0];
    const [first, last] = [+svgs[0].dataset.from, +svgs[0].dataset.to];
    const figures = [...new Set(svgs.map(svg => svg.parentElement))];
    let a = first, b = last, marked = null, figure = figures[0];
    const x = t => width() * (t - a) / (b - a);
    const inside = t => Math.min(Math.max(t, a), b);

    const mark = (t, spoken) => {
      marked = t === null || t < a || t > b ? null : t;
      pictures.forEach(p => p.mark(marked === null ? null : x(marked).toFixed(1)));
      readOut.hidden = marked === null;
      if (marked === null) return;
      // What a mouse passes over is not read to who cannot see it.
      readOut.ariaLive = spoken ? "polite" : "off";
      const digits = Math.max(0, Math.ceil(-Math.log10((b - a) / width())));
      const values = pictures.filter(p => p.svg.parentElement === figure).flatMap(p => p.read(marked));
      readOut.replaceChildren(...[`${marked.toFixed(Math.min(digits, 6))} s`, ...values].map(text => {
        const part = document.createElement("span");
        part.textContent = text;
        return part;
      }));
    };
    const draw = () => {
      const whole = a === first && b === last;
      pictures.forEach(p => p.draw(a, b, whole, x));
      for (const f of figures) {
        f.classList.toggle("zoomed", !whole);
        f.dataset.view = `${a}..${b}`;
      }
      mark(marked);
    };
    const fit = () => {
      for (const p of pictures) {
        p.svg.parentElement.classList.add("fits");
        p.fit(p.svg.parentElement.clientWidth);
      }
      draw();
    };
    const show = (from, to) => {
      const wide = Math.min(last - first, Math.max(to - from, (last - first) / 20000));
      a = Math.min(Math.max(from, first), last - wide);
      b = a + wide;
      draw();
    };
    const all = () => show(first, last);
    const zoom = (by, at) => show(at - (at - a) * by, at + (b - at) * by);

    for (const f of figures) {
      const box = () => f.querySelector(".field").getBoundingClientRect();
      const time = clientX => a + (clientX - box().left) / box().width * (b - a);
      const over = f => { figure = f; };
      let from = null;
      // Each finger stays on the instant it was set on: one moves the view, two stretch it.
      const fingers = new Map();
      const follow = () => {
        const [one, two] = [...fingers.values()], { left, width } = box();
        if (two && Math.abs(two.x - one.x) > 20 && (two.x - one.x) * (two.t - one.t) > 0) {
          const each = (two.t - one.t) / (two.x - one.x), start = one.t - each * (one.x - left);
          show(start, start + each * width);
        } else if (!two && b - a < last - first) {
          const by = one.t - time(one.x);
          show(a + by, b + by);
        }
      };
      f.addEventListener("wheel", e => {
        if (!e.ctrlKey && !e.shiftKey) return;
        e.preventDefault();
        zoom((e.deltaY || e.deltaX) > 0 ? 1.25 : 0.8, inside(time(e.clientX)));
      }, { passive: false });
      f.addEventListener("pointerdown", e => {
        over(f);
        if (e.pointerType === "touch") fingers.set(e.pointerId, { x: e.clientX, t: time(e.clientX) });
        else if (e.button === 0) from = inside(time(e.clientX));
        mark(inside(time(e.clientX)));
      });
      f.addEventListener("pointermove", e => {
        over(f);
        if (fingers.has(e.pointerId)) {
          fingers.get(e.pointerId).x = e.clientX;
          follow();
        }
        const t = time(e.clientX);
        mark(a <= t && t <= b ? t : null);
        if (from !== null) pictures.forEach(p => p.pick(x(from), x(inside(t))));
      });
      const leave = e => {
        fingers.delete(e.pointerId);
        from = null;
        pictures.forEach(p => p.pick(0, 0));
      };
      f.addEventListener("pointerup", e => {
        const to = inside(time(e.clientX)), start = from;
        leave(e);
        if (start !== null && Math.abs(x(to) - x(start)) > 8) show(Math.min(start, to), Math.max(start, to));
      });
      f.addEventListener("pointercancel", leave);
      f.addEventListener("pointerleave", e => { leave(e); if (e.pointerType !== "touch") mark(null); });
      f.addEventListener("dblclick", all);
      f.addEventListener("blur", () => mark(null));
      f.addEventListener("keydown", e => {
        if (e.ctrlKey || e.metaKey || e.altKey) return;
        const middle = marked ?? (a + b) / 2, pan = (b - a) / 5, step = (b - a) / 200;
        const move = by => { over(f); mark(inside(middle + by), true); };
        const key = (e.shiftKey && e.key.startsWith("Arrow") ? "Shift" : "") + e.key;
        const act = {
          "+": () => zoom(0.5, middle), "-": () => zoom(2, middle), 0: all,
          ArrowLeft: () => show(a - pan, b - pan), ArrowRight: () => show(a + pan, b + pan),
          ",": () => move(-step), ".": () => move(step), ShiftArrowLeft: () => move(-10 * step), ShiftArrowRight: () => move(10 * step),
          Escape: () => { if (marked === null) all(); else mark(null); },
        }[key];
        if (!act) return;
        e.preventDefault();
        act();
      });
      f.setAttribute("aria-describedby", "keys");
    }
    addEventListener("resize", fit);
    addEventListener("beforeprint", () => {
      mark(null);
      pictures.forEach(p => p.fit(Infinity));
      all();
    });
    addEventListener("afterprint", fit);
    // The pictures of what is told in a table of events are those where it stands.
    const told = svgs.find(svg => svg.querySelector("[data-spans]")) ?? svgs[0];
    const visit = t => {
      figure = told.parentElement;
      show(t - (last - first) / 70, t + (last - first) / 35);
      mark(t, true);
      told.scrollIntoView({ block: "center", behavior: matchMedia("(prefers-reduced-motion: reduce)").matches ? "auto" : "smooth" });
    };
    fit();
    return { show, visit };
  };

  const svgs = [...document.querySelectorAll("svg.time")];
  if (!svgs.length) return;
  const keyOf = svg => svg.dataset.from + " " + svg.dataset.to;
  const [{ show, visit }] = [...new Set(svgs.map(keyOf))].map(key => axis(svgs.filter(svg => keyOf(svg) === key)));
  document.getElementById("keys").hidden = false;

  // The rows of a table of events are buttons that go there.
  const events = [...document.querySelectorAll("[data-at]")];
  for (const cell of events) {
    const button = document.createElement("button");
    button.textContent = cell.textContent;
    button.title = "show in the pictures";
    button.onclick = () => visit(+cell.dataset.at);
    cell.replaceChildren(button);
  }

  // A link ending in #t=20..30 opens on that stretch, one in #event=2 at the second event.
  const linked = () => {
    const stretch = /^#t=([\d.]+?)\.\.([\d.]+)$/.exec(location.hash), event = /^#event=(\d+)$/.exec(location.hash);
    if (stretch && +stretch[2] > +stretch[1]) show(+stretch[1], +stretch[2]);
    if (event && events[event[1] - 1]) visit(+events[event[1] - 1].dataset.at);
  };
  addEventListener("hashchange", linked);
  // What is folded on the screen is not on paper.
  const folded = [...document.querySelectorAll("details:not([open])")];
  addEventListener("beforeprint", () => folded.forEach(details => { details.open = true; }));
  linked();
})();
