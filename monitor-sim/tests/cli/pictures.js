// What there is to see of each picture of the page.
const picturesSeen = () => [...document.querySelectorAll("svg[role=img]")].map(svg => {
  const marks = [...svg.querySelectorAll(".curve, .solid")].map(mark => mark.getBBox());
  const { left, right, top, bottom, width } = svg.getBoundingClientRect();
  const shown = [...svg.querySelectorAll("text")].filter(text => text.getAttribute("visibility") !== "hidden");
  const texts = shown.map(text => [text.textContent, text.getBoundingClientRect()]);
  // Boxes are higher than letters.
  const meet = (a, b) => a.left < b.right && b.left < a.right && a.top + 3 < b.bottom && b.top + 3 < a.bottom;
  const beyond = a => a.left < left - 1 || a.right > right + 1 || a.top < top - 1 || a.bottom > bottom + 1;
  const crowded = texts.filter(([, a], n) => beyond(a) || texts.slice(0, n).some(([, b]) => meet(a, b)));
  return {
    alternative: svg.getAttribute("aria-label"),
    width,
    drawn: marks.some(mark => mark.width > 1),
    crowded: crowded.map(([text]) => text),
  };
});

const report = seen => {
  const result = document.createElement("pre");
  result.id = "seen";
  result.textContent = JSON.stringify(seen);
  document.body.append(result);
};
