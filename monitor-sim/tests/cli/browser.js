// Uses the page as a reader would, and leaves what came of it in the document.
(() => {
  const seen = {};
  const plot = document.querySelector(".plot[data-name=speed]"), curve = plot.querySelector(".curve");
  const speed = plot.closest("[role=group]");
  const view = () => speed.dataset.view.split("..").map(Number);
  const box = () => plot.querySelector(".field").getBoundingClientRect();
  const clientX = share => box().left + share * box().width;
  const point = (type, share, more = {}) => {
    const at = { clientX: clientX(share), clientY: box().top + 9, pointerType: "mouse" };
    speed.dispatchEvent(new PointerEvent(type, { bubbles: true, ...at, ...more }));
  };
  const press = (key, more = {}) => speed.dispatchEvent(new KeyboardEvent("keydown", { bubbles: true, key, ...more }));
  const readOut = document.querySelector("output");
  const read = () => (readOut.hidden ? null : [...readOut.children].map(part => part.textContent));
  const points = () => curve.getAttribute("d").split(/[ML]/).slice(1).map(pair => +pair.split(" ")[0]);

  seen.linked = view();
  seen.pictures = picturesSeen();

  press("0");
  seen.whole = view();
  seen.drawn = points();
  const buttons = [...document.querySelectorAll("th button")];
  seen.events = buttons.map(button => +button.textContent);
  buttons[0].click();
  seen.visited = view();
  seen.zoomed = points().filter(x => x >= 0 && x <= 832).length;
  seen.told = read();
  press("Escape");
  seen.escaped = read();

  point("pointermove", 0.6);
  seen.hovered = read();
  seen.crosses = [...document.querySelectorAll(".cross")].map(cross => cross.getAttribute("d"));
  press(".");
  seen.stepped = read();
  point("pointerleave", 0.6);
  seen.left = read();

  press("+");
  seen.nearer = view();
  press("ArrowRight");
  seen.further = view();

  press("0");
  point("pointerdown", 0.25);
  point("pointermove", 0.5);
  point("pointerup", 0.5);
  seen.dragged = view();

  press("0");
  const finger = (type, pointerId, share) => point(type, share, { pointerType: "touch", pointerId });
  finger("pointerdown", 1, 0.4);
  finger("pointerdown", 2, 0.6);
  finger("pointermove", 1, 0.2);
  finger("pointermove", 2, 0.8);
  seen.pinched = view();
  finger("pointerup", 2, 0.8);
  finger("pointermove", 1, 0.3);
  finger("pointerup", 1, 0.3);
  seen.panned = view();

  document.body.style.width = "400px";
  dispatchEvent(new Event("resize"));
  const letters = 14 * plot.ownerSVGElement.getScreenCTM().a;
  seen.narrow = { letters, scrolls: speed.scrollWidth > speed.clientWidth, points: points().length };

  dispatchEvent(new Event("beforeprint"));
  const unfolded = document.querySelectorAll("details:not([open])").length === 0;
  seen.printed = { view: view(), points: points().length, read: read(), unfolded };

  report(seen);
})();
