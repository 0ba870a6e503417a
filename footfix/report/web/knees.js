// The change of the knees: by how much more each of them is bent after than before, over time.

const KNEE_PLOT = 44; // height in CSS pixels
const LEAST_CHANGE = 0.3; // [degrees] rows in which no knee changes by more are left out

/** Rows of knees that changed, those of a pair of legs together: {name, legs: [{name, side, change}], most}. */
function kneeRows(motion) {
  const rows = new Map();
  for (const [hip, knee, ankle, name] of motion.legs) {
    const pair = name.replace(/_?(left|right)/i, "");
    const change = new Float32Array(motion.shown);
    for (let i = 0; i < motion.shown; i++) {
      const [was, is] = ["before", "after"].map((when) => flexion(motion, motion.joints[when], i, [hip, knee, ankle]));
      change[i] = is - was;
    }
    const row = rows.get(pair) || { name: pair ? `${pair.replaceAll("_", " ")} knees` : "knees", legs: [], most: 0 };
    row.legs.push({ name: name.replaceAll("_", " "), change });
    row.most = change.reduce((most, value) => Math.max(most, Math.abs(value)), row.most);
    rows.set(pair, row);
  }
  return [...rows.values()].filter((row) => row.most > LEAST_CHANGE);
}

/** [degrees] of a knee; 0 where the leg is straight. */
function flexion({ parents }, positions, i, joints) {
  const [hip, knee, ankle] = joints.map((joint) => (i * parents.length + joint) * 3);
  const thigh = [0, 1, 2].map((k) => positions[knee + k] - positions[hip + k]);
  const shank = [0, 1, 2].map((k) => positions[ankle + k] - positions[knee + k]);
  const [a, b, c] = thigh;
  const [d, e, f] = shank;
  const across = Math.hypot(b * f - c * e, c * d - a * f, a * e - b * d);
  return (Math.atan2(across, a * d + b * e + c * f) * 180) / Math.PI;
}

function drawKnees(timeline, context, theme, row, top) {
  const most = Math.max(row.most, 2);
  const middle = top + KNEE_PLOT / 2;
  const y = (degrees) => middle - (degrees * (KNEE_PLOT - 6)) / (2 * most);
  const x = timeline.gutter - 8;
  context.textAlign = "right";
  context.textBaseline = "middle";
  context.font = theme.strong;
  context.fillStyle = theme.ink;
  context.fillText(shorten(context, row.name, timeline.gutter - 10), x, middle);
  context.font = theme.small;
  context.fillStyle = theme.muted;
  context.fillText(`+${most.toFixed(0)}°`, x, top + 6);
  context.fillText(`−${most.toFixed(0)}°`, x, top + KNEE_PLOT - 6);
  rule(timeline, context, theme, middle, []);
  for (const leg of row.legs) {
    curve(timeline, context, (i) => y(leg.change[i]), sideColor(theme, { side: "", name: leg.name }), "after", top, KNEE_PLOT);
  }
}

/** The change of a row of knees at a frame, in words. */
function kneesInWords(row, index) {
  return row.legs.map(({ name, change }) => {
    const degrees = change[index];
    return `${name} knee ${Math.abs(degrees).toFixed(1)}° ${degrees >= 0 ? "more" : "less"} bent than before`;
  }).join(", ");
}
