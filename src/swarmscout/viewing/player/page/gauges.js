// Scale, axes and compass of a view: where north is, how long a metre is.

/** The largest of 1, 2, 5 × 10ⁿ that is at most as large as a length. */
function roundLength(wanted) {
  const power = 10 ** Math.floor(Math.log10(wanted));
  return [5, 2, 1].map((part) => part * power).find((length) => length <= wanted) ?? power;
}

function label(ctx, theme, text, x, y, align = "left") {
  ctx.font = "11px system-ui, sans-serif";
  ctx.textAlign = align;
  ctx.textBaseline = "alphabetic";
  ctx.lineJoin = "round";
  ctx.lineWidth = 3;
  ctx.strokeStyle = theme.halo;
  ctx.strokeText(text, x, y);
  ctx.fillStyle = theme.text;
  ctx.fillText(text, x, y);
}

function stroke(ctx, theme, draw, width = 1.6) {
  for (const [colour, extra] of [[theme.halo, 2.5], [theme.text, 0]]) {
    ctx.strokeStyle = colour;
    ctx.lineWidth = width + extra;
    ctx.beginPath();
    draw();
    ctx.stroke();
  }
}

/** A bar of a round length at the lower left. */
export function drawScale(ctx, sheet, pixelsPerMetre, theme, where = "") {
  const length = roundLength((0.22 * sheet.width) / pixelsPerMetre);
  const [x, y] = [46, sheet.height - 32];
  stroke(ctx, theme, () => {
    ctx.moveTo(x, y - 4);
    ctx.lineTo(x, y);
    ctx.lineTo(x + length * pixelsPerMetre, y);
    ctx.lineTo(x + length * pixelsPerMetre, y - 4);
  });
  label(ctx, theme, `${length} m${where}`, x + 4, y - 6);
}

/**
 * Arrows along x (east) and y (north) at the lower right.
 *
 * @param east, north where the axes point on the screen, [right, up], at most 1 long.
 */
export function drawCompass(ctx, sheet, theme, east, north) {
  const [x, y] = [sheet.width - 52, sheet.height - 46];
  for (const [[right, up], name] of [[east, "x"], [north, "N · y"]]) {
    const [ex, ey] = [x + 26 * right, y - 26 * up];
    const angle = Math.atan2(ey - y, ex - x);
    stroke(ctx, theme, () => {
      ctx.moveTo(x, y);
      ctx.lineTo(ex, ey);
      for (const side of [-0.45, 0.45]) {
        ctx.moveTo(ex, ey);
        ctx.lineTo(ex - 7 * Math.cos(angle + side), ey - 7 * Math.sin(angle + side));
      }
    });
    label(ctx, theme, name, x + 38 * right, y - 38 * up + 4, "center");
  }
}

/** Coordinates in metres along the lower and the left edge. */
export function drawAxes(ctx, sheet, toMetres, toPixels, pixelsPerMetre, theme) {
  const step = roundLength(90 / pixelsPerMetre);
  const [left, bottom] = toMetres(0, sheet.height);
  const [right, top] = toMetres(sheet.width, 0);
  const digits = Math.max(0, -Math.floor(Math.log10(step)));
  for (let x = Math.ceil(left / step) * step; x <= right; x += step) {
    const [px] = toPixels(x, bottom);
    if (px < 40 || px > sheet.width - 24) continue;
    stroke(ctx, theme, () => {
      ctx.moveTo(px, sheet.height);
      ctx.lineTo(px, sheet.height - 5);
    }, 1);
    label(ctx, theme, `${x.toFixed(digits)}`, px, sheet.height - 8, "center");
  }
  for (let y = Math.ceil(bottom / step) * step; y <= top; y += step) {
    const [, py] = toPixels(left, y);
    if (py < 14 || py > sheet.height - 24) continue;
    stroke(ctx, theme, () => {
      ctx.moveTo(0, py);
      ctx.lineTo(5, py);
    }, 1);
    label(ctx, theme, `${y.toFixed(digits)}`, 8, py + 4);
  }
  label(ctx, theme, "m", 8, sheet.height - 8);
}
