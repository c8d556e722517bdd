// Pictures over the same time share one view of it, [a, b] in seconds, and a cross-hair.

const readOut = make("output", document.body, { class: "read", hidden: "" });

// What these pictures, all over the same time, do together.
const together = svgs => {
  const pictures = svgs.map(pictureOf), { width } = pictures[0];
  const [first, last] = [+svgs[0].dataset.from, +svgs[0].dataset.to];
  const figures = [...new Set(svgs.map(svg => svg.parentElement))];
  let a = first, b = last, marked = null, figure = figures[0];
  const x = t => width() * (t - a) / (b - a);
  const inside = t => Math.min(Math.max(t, a), b);

  // Marks an instant, and says what the pictures of the figure in use read there.
  const mark = (t, aloud) => {
    marked = t === null || t < a || t > b ? null : t;
    pictures.forEach(p => p.mark(marked === null ? null : x(marked)));
    readOut.hidden = marked === null;
    if (marked === null) return;
    // What a mouse passes over is not read to who cannot see it.
    readOut.ariaLive = aloud ? "polite" : "off";
    const digits = Math.min(Math.max(0, Math.ceil(-Math.log10((b - a) / width()))), 6);
    // What is shaded is shaded in each of them.
    const values = new Set(pictures.filter(p => p.svg.parentElement === figure).flatMap(p => p.read(marked)));
    readOut.replaceChildren();
    for (const text of [`${marked.toFixed(digits)} s`, ...values]) make("span", readOut, {}).textContent = text;
  };
  const draw = () => {
    const all = a === first && b === last;
    pictures.forEach(p => p.draw(a, b, all, x));
    for (const f of figures) {
      f.classList.toggle("zoomed", !all);
      f.dataset.view = `${a}..${b}`;
    }
    mark(marked);
  };
  const show = (from, to) => {
    const wide = Math.min(last - first, Math.max(to - from, (last - first) / 20000));
    a = Math.min(Math.max(from, first), last - wide);
    b = a + wide;
    draw();
  };
  const all = () => show(first, last);
  const zoom = (by, at) => show(at - (at - a) * by, at + (b - at) * by);
  const fit = () => {
    // A page that is not shown has no width.
    const pixels = Math.max(...figures.map(f => f.clientWidth)) || Infinity;
    pictures.forEach(p => p.fit(pixels));
    draw();
  };

  for (const f of figures) {
    f.classList.add("fits");
    f.setAttribute("aria-describedby", "keys");
    const box = () => f.querySelector(".field").getBoundingClientRect();
    const time = clientX => a + (clientX - box().left) / box().width * (b - a);

    f.addEventListener("wheel", e => {
      if (!e.ctrlKey && !e.shiftKey) return;
      e.preventDefault();
      zoom((e.deltaY || e.deltaX) > 0 ? 1.25 : 0.8, inside(time(e.clientX)));
    }, { passive: false });

    // A mouse marks what it is over and drags over a stretch. Each finger stays on the instant it was set on: one moves the
    // view, two stretch it.
    let dragged = null;
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
    const end = e => {
      fingers.delete(e.pointerId);
      dragged = null;
      pictures.forEach(p => p.pick(0, 0));
    };
    f.addEventListener("pointerdown", e => {
      const t = time(e.clientX);
      figure = f;
      if (e.pointerType === "touch") fingers.set(e.pointerId, { x: e.clientX, t });
      else if (e.button === 0) dragged = inside(t);
      mark(inside(t));
    });
    f.addEventListener("pointermove", e => {
      figure = f;
      if (fingers.has(e.pointerId)) {
        fingers.get(e.pointerId).x = e.clientX;
        follow();
      }
      const t = time(e.clientX);
      mark(a <= t && t <= b ? t : null);
      if (dragged !== null) pictures.forEach(p => p.pick(x(dragged), x(inside(t))));
    });
    f.addEventListener("pointerup", e => {
      const from = dragged, to = inside(time(e.clientX));
      end(e);
      if (from !== null && Math.abs(x(to) - x(from)) > 8) show(Math.min(from, to), Math.max(from, to));
    });
    f.addEventListener("pointercancel", end);
    f.addEventListener("pointerleave", e => {
      end(e);
      if (e.pointerType !== "touch") mark(null);
    });
    f.addEventListener("dblclick", all);
    f.addEventListener("blur", () => mark(null));

    f.addEventListener("keydown", e => {
      if (e.ctrlKey || e.metaKey || e.altKey) return;
      const middle = marked ?? (a + b) / 2, pan = (b - a) / 5, step = (b - a) / 200;
      const move = by => {
        figure = f;
        mark(inside(middle + by), true);
      };
      const act = {
        "+": () => zoom(0.5, middle),
        "-": () => zoom(2, middle),
        0: all,
        ArrowLeft: () => show(a - pan, b - pan),
        ArrowRight: () => show(a + pan, b + pan),
        ",": () => move(-step),
        ".": () => move(step),
        ShiftArrowLeft: () => move(-10 * step),
        ShiftArrowRight: () => move(10 * step),
        Escape: () => (marked === null ? all() : mark(null)),
      }[(e.shiftKey && e.key.startsWith("Arrow") ? "Shift" : "") + e.key];
      if (!act) return;
      e.preventDefault();
      act();
    });
  }

  addEventListener("resize", fit);
  addEventListener("beforeprint", () => {
    mark(null);
    pictures.forEach(p => p.fit(Infinity));
    all();
  });
  addEventListener("afterprint", fit);

  // What is told in a table of events stands in the first picture of logical outputs.
  const told = svgs.find(svg => svg.querySelector("[data-spans]")) ?? svgs[0];
  const visit = t => {
    figure = told.parentElement;
    figure.focus({ preventScroll: true });
    show(t - (last - first) / 70, t + (last - first) / 35);
    mark(t, true);
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    told.scrollIntoView({ block: "center", behavior: still ? "auto" : "smooth" });
  };
  fit();
  return { show, visit };
};

const svgs = [...document.querySelectorAll("svg.time")];
const sameTime = svg => svgs.filter(other => other.dataset.from === svg.dataset.from && other.dataset.to === svg.dataset.to);
const [main] = svgs.filter(svg => sameTime(svg)[0] === svg).map(svg => together(sameTime(svg)));
document.getElementById("keys").hidden = !main;

// The rows of a table of events are buttons that go there.
const events = main ? [...document.querySelectorAll("[data-at]")] : [];
for (const cell of events) {
  const button = document.createElement("button");
  button.textContent = cell.textContent;
  button.title = "show in the pictures";
  button.onclick = () => main.visit(+cell.dataset.at);
  cell.replaceChildren(button);
}

// A link ending in #t=20..30 opens on that stretch, one in #event=2 at the second event.
const linked = () => {
  const stretch = /^#t=([\d.]+?)\.\.([\d.]+)$/.exec(location.hash), event = /^#event=(\d+)$/.exec(location.hash);
  if (stretch && +stretch[2] > +stretch[1]) main?.show(+stretch[1], +stretch[2]);
  if (event && events[event[1] - 1]) main.visit(+events[event[1] - 1].dataset.at);
};
addEventListener("hashchange", linked);
linked();

// What is folded on the screen is not on paper.
let folded = [];
const unfold = open => folded.forEach(details => { details.open = open; });
addEventListener("beforeprint", () => {
  folded = [...document.querySelectorAll("details:not([open])")];
  unfold(true);
});
addEventListener("afterprint", () => unfold(false));
