// Signals, as the pictures hold them.

// Four digits, as the page's tables have them.
const number = value => {
  const magnitude = Math.floor(Math.log10(Math.abs(value)));
  if (value === 0) return "0";
  return magnitude < -5 || magnitude > 5 ? value.toExponential(3).replace("+", "") : value.toFixed(Math.max(0, 3 - magnitude));
};

// A signal's pieces: where each begins, how far apart its values are, and the least and greatest of each value, on the axis of
// its picture. The first piece is the whole signal in bins, the others hold every sample.
const decoded = ({ low, span, pieces, codes }) => {
  const digit = at => codes.charCodeAt(at) - 63, gap = 2 ** 18 - 1;
  const value = n => {
    const code = digit(3 * n) << 12 | digit(3 * n + 1) << 6 | digit(3 * n + 2);
    return code === gap ? NaN : +low + span * code / (gap - 1);
  };
  let end = 0;
  return pieces.split(";").map(piece => {
    const [from, step, each, count] = piece.split(" ").map(Number), first = end;
    end += each * count;
    const least = k => value(first + each * k), greatest = k => value(first + each * (k + 1) - 1);
    return { from, step, each, count, to: from + step * count, least, greatest };
  });
};

// The finest piece at t, and the index of its value there.
const nearest = (pieces, t) => {
  const piece = pieces.findLast(p => p.from <= t && t < p.to) ?? pieces[0];
  const k = (t - piece.from) / piece.step;
  return [piece, Math.min(Math.max(piece.each > 1 ? Math.floor(k) : Math.round(k), 0), piece.count - 1)];
};

// The path of a signal from a to b. All values in a column of pixels are one stroke from the least to the greatest.
const pathBetween = (pieces, a, b, x, y) => {
  let path = "", at = a, pen = "M", column = null, before = null;
  const point = (t, value) => {
    path += `${pen}${x(t).toFixed(1)} ${y(value)}`;
    pen = "L";
  };
  const stroke = () => {
    if (!column) return;
    const { from, to, least, greatest } = column, middle = (least + greatest) / 2;
    // The nearer end first.
    const down = before !== null && before > middle;
    point(from, down ? greatest : least);
    if (least !== greatest) point(to, down ? least : greatest);
    before = middle;
    column = null;
  };
  const take = (from, to, least, greatest) => {
    if (Number.isNaN(least)) {
      stroke();
      pen = "M";
    } else if (column && x(from) - x(column.from) < 1) {
      column = { from: column.from, to, least: Math.min(column.least, least), greatest: Math.max(column.greatest, greatest) };
    } else {
      stroke();
      column = { from, to, least, greatest };
    }
  };
  const part = (piece, to) => {
    // One value more on either side, so that the line crosses the edges of the plot.
    const last = Math.min(Math.ceil((to - piece.from) / piece.step) + 1, piece.count);
    for (let k = Math.max(Math.floor((at - piece.from) / piece.step) - 1, 0); k < last; k++) {
      const t = piece.from + k * piece.step;
      if (t >= to && to < b) break;
      take(t, piece.each > 1 ? t + piece.step : t, piece.least(k), piece.greatest(k));
    }
    at = to;
  };
  const [whole, ...closeUps] = pieces;
  for (const closeUp of closeUps.filter(p => p.from < b && p.to > a)) {
    if (closeUp.from > at) part(whole, closeUp.from);
    part(closeUp, Math.min(closeUp.to, b));
  }
  if (at < b) part(whole, b);
  stroke();
  return path;
};
